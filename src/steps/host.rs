//! Work of the host between steps.

use web_time::Instant;

use crate::{
    Error,
    frame::{driver::Driver, targets::Target},
    gpu::{Gpu, check_bytes},
    layout,
    method::BufferDepth,
    steps::reproject,
};

/// Runs pass 2 of `AdelsonHodges`, row after row.
pub(crate) async fn sweep(driver: &mut Driver<'_>, view: usize) -> Result<(), Error> {
    let (gpu, targets, frame) = (driver.gpu, driver.targets, driver.frames[view]);
    let submission = gpu.checked(|| Ok(gpu.submit([]))).await?;
    gpu.finished(submission).await?;
    let begin = Instant::now();
    let width = frame.image_size[0] as usize;
    let rows = frame.row_begin as usize * width..frame.row_end as usize * width;
    let source: Vec<layout::Pixel> = gpu.read(targets.get(Target::View, driver.eyes.sources[view]), rows.end).await?;
    let depths: Vec<f32> = source[rows.clone()].iter().map(|pixel| pixel.depth).collect();
    let keys = crate::cpu::adelson_hodges::sweep(&driver.eyes.cpu_frame(view), &depths);
    let marked: Vec<_> = keys.into_iter().map(|marks| layout::Pixel { marks, ..Default::default() }).collect();
    let offset = (rows.start * size_of::<layout::Pixel>()) as u64;
    gpu.queue.write_buffer(targets.get(Target::View, view), offset, bytemuck::cast_slice(&marked));
    driver.host += begin.elapsed();
    Ok(())
}

/// Reprojects with the 3D buffer, as many rows at a time as fit one binding.
pub(crate) async fn slots(driver: &mut Driver<'_>, depth: BufferDepth, view: usize) -> Result<(), Error> {
    let range = match depth {
        BufferDepth::Adaptive => depth_range(driver, view).await?,
        _ => (f32::INFINITY, f32::INFINITY),
    };
    let depth = depth.slots(&driver.eyes.pair_of(view), range);
    let rows = size_slots(driver, depth, view).await?;
    let gpu = driver.gpu;
    let band = driver.frames[view];
    for begin in (band.row_begin..band.row_end).step_by(rows as usize) {
        let run = || {
            let frame = &mut driver.frames[view];
            (frame.row_begin, frame.row_end) = (begin, band.row_end.min(begin + rows));
            driver.upload_frames();
            let mut encoder = driver.encoder();
            driver.encode_all(&mut encoder, &reproject::slots(view));
            gpu.queue.submit([encoder.finish()]);
            Ok(())
        };
        gpu.checked(run).await?;
    }
    driver.frames[view] = layout::Frame { buffer_depth: depth, ..band };
    driver.upload_frames();
    Ok(())
}

/// Sizes the 3D buffer for this depth, and returns how many rows it holds.
async fn size_slots(driver: &mut Driver<'_>, depth: u32, view: usize) -> Result<u32, Error> {
    let frame = &mut driver.frames[view];
    frame.buffer_depth = depth;
    let row_bytes = u64::from(frame.image_size[0]) * u64::from(depth) * 4;
    let allowed = driver.gpu.binding_limit();
    check_bytes(&format!("one row of a 3D buffer {depth} deep"), row_bytes, allowed, "use a smaller depth")?;
    let rows = (allowed / row_bytes).min(u64::from(frame.row_end - frame.row_begin)) as u32;
    let bytes = u64::from(rows) * row_bytes;
    if driver.slots.as_ref().is_none_or(|slots| slots.size() < bytes) {
        // A buffer that is too small is freed before the new one is made.
        driver.slots.take().iter().for_each(wgpu::Buffer::destroy);
        *driver.slots = Some(driver.gpu.checked(|| Ok(driver.gpu.storage_buffer("slots", bytes))).await?);
    }
    driver.slot_bytes = bytes;
    driver.most_slot_bytes = driver.most_slot_bytes.max(bytes);
    driver.buffer_depth = driver.buffer_depth.max(depth);
    Ok(rows)
}

/// Returns the nearest and farthest depth of a view's source in the rows at work. The farthest is infinite if any pixel
/// is sky.
async fn depth_range(driver: &mut Driver<'_>, view: usize) -> Result<(f32, f32), Error> {
    let (gpu, frame): (&Gpu, _) = (driver.gpu, driver.frames[view]);
    let words = frame.row_end as usize * layout::COUNTERS;
    let counters = driver.targets.get(Target::Counters, driver.eyes.sources[view]);
    let words: Vec<u32> = gpu.read(counters, words).await?;
    let rows = words.chunks_exact(layout::COUNTERS).skip(frame.row_begin as usize);
    Ok(rows.fold((f32::INFINITY, 0.0), |(nearest, farthest), row| {
        let far = match f32::from_bits(row[layout::FARTHEST_DEPTH]) {
            far if far >= crate::FAR => f32::INFINITY,
            far => far,
        };
        (nearest.min(f32::from_bits(row[layout::NEAREST_DEPTH])), farthest.max(far))
    }))
}
