//! What the host does between bands.

use std::sync::Arc;

use web_time::Instant;

use crate::{
    Error, Method,
    auto::CostModel,
    frame::{
        driver::Driver,
        plan::{Made, Step, targets},
        read::sum_of,
        targets::Target,
    },
    gpu::check_bytes,
    layout,
    method::BufferDepth,
    steps::{bracket, trace},
};

/// Pass 2 of `AdelsonHodges`, row after row.
pub(crate) async fn sweep(driver: &mut Driver<'_>, view: usize) -> Result<(), Error> {
    let (gpu, targets) = (driver.gpu, driver.targets);
    let submission = gpu.checked(|| Ok(gpu.submit([]))).await?;
    gpu.finished(submission).await?;
    let begin = Instant::now();
    let pixels = driver.eyes.pose.size[0] as usize * driver.eyes.pose.size[1] as usize;
    let source: Vec<layout::Pixel> = gpu.read(targets.get(Target::View, driver.eyes.sources[view]), pixels).await?;
    let depths: Vec<f32> = source.iter().map(|pixel| pixel.depth).collect();
    let keys = crate::cpu::adelson_hodges::sweep(&driver.eyes.cpu_frame(view), &depths);
    let marked: Vec<_> = keys.into_iter().map(|marks| layout::Pixel { marks, ..Default::default() }).collect();
    gpu.queue.write_buffer(targets.get(Target::View, view), 0, bytemuck::cast_slice(&marked));
    driver.host += begin.elapsed();
    Ok(())
}

/// How deep the 3D buffer is, and how many rows of it fit one binding.
pub(crate) async fn size_slots(driver: &mut Driver<'_>, depth: BufferDepth, view: usize) -> Result<(), Error> {
    let range = match depth {
        BufferDepth::Adaptive => depth_range(driver, driver.eyes.sources[view]).await?,
        _ => (f32::INFINITY, f32::INFINITY),
    };
    let depth = depth.slots(&driver.eyes.pair_of(view), range);
    let [width, height] = driver.eyes.pose.size;
    let row_bytes = u64::from(width) * u64::from(depth) * 4;
    let allowed = driver.gpu.binding_limit();
    check_bytes(&format!("one row of a 3D buffer {depth} deep"), row_bytes, allowed, "use a smaller depth")?;
    let rows = (allowed / row_bytes).min(u64::from(height.min(driver.rows))) as u32;
    let bytes = u64::from(rows) * row_bytes;
    // One that is too small goes before the new one comes.
    let slots = match driver.slots.take().filter(|slots| slots.size() >= bytes) {
        Some(slots) => slots,
        None => driver.gpu.checked(|| Ok(Arc::new(driver.gpu.storage_buffer("slots", bytes)))).await?,
    };
    *driver.slots = Some(slots);
    (driver.slot_bytes, driver.rows) = (bytes, rows);
    driver.frames[view].buffer_depth = depth;
    Ok(())
}

/// Nearest and farthest depth of a view; the farthest is infinite as soon as one pixel is sky.
async fn depth_range(driver: &mut Driver<'_>, view: usize) -> Result<(f32, f32), Error> {
    let words = counters(driver, view).await?;
    let rows = words.chunks_exact(layout::COUNTERS);
    Ok(rows.fold((f32::INFINITY, 0.0), |(nearest, farthest), row| {
        let far = match f32::from_bits(row[layout::FARTHEST_DEPTH]) {
            far if far >= crate::FAR => f32::INFINITY,
            far => far,
        };
        (nearest.min(f32::from_bits(row[layout::NEAREST_DEPTH])), farthest.max(far))
    }))
}

/// What sources say of the cost of the views that are made from them, and the steps that follow.
pub(crate) async fn choose(driver: &mut Driver<'_>) -> Result<Vec<Step>, Error> {
    let mut steps = Vec::new();
    for (view, source) in targets(&driver.eyes.sources) {
        let shadow_rays = sum_of(&counters(driver, source).await?, layout::SHADOW_RAYS);
        let gaps = sum_of(&counters(driver, view).await?, layout::GAP_PIXELS);
        let choice = CostModel::of(driver.gpu).choose(&driver.eyes.pose, shadow_rays, gaps);
        log::debug!("view {view}: {choice}");
        let (made, more) = match choice.method {
            Method::Naive => (Made::Traced, trace::target(view)),
            _ => (Made::Bracketed, bracket::resolve(view)),
        };
        (driver.choices[view], driver.made[view]) = (Some(choice), made);
        steps.extend(more);
    }
    Ok(steps)
}

async fn counters(driver: &mut Driver<'_>, view: usize) -> Result<Vec<u32>, Error> {
    let words = driver.eyes.pose.size[1] as usize * layout::COUNTERS;
    driver.gpu.read(driver.targets.get(Target::Counters, view), words).await
}
