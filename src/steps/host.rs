//! What the host does between bands.

use std::sync::Arc;

use web_time::Instant;

use crate::{
    Error, Method,
    auto::CostModel,
    frame::{
        driver::Driver,
        plan::{RightView, Step, by_bracket, by_naive},
        read::sum_of,
        targets::Target,
    },
    gpu::check_bytes,
    layout,
    method::BufferDepth,
};

/// Pass 2 of `AdelsonHodges`, row after row.
pub(crate) async fn sweep(driver: &mut Driver<'_>) -> Result<(), Error> {
    let (gpu, targets) = (driver.gpu, driver.targets);
    let submission = gpu.checked(|| Ok(gpu.submit([]))).await?;
    gpu.finished(submission).await?;
    let begin = Instant::now();
    let pixels = driver.pose.size[0] as usize * driver.pose.size[1] as usize;
    let stride = targets.shape.kept.bytes() as usize / 4;
    let words: Vec<f32> = gpu.read(targets.get(Target::Hits), pixels * stride).await?;
    let depths: Vec<f32> = words.iter().step_by(stride).copied().collect();
    let right_source = crate::cpu::adelson_hodges::sweep(&crate::cpu::Frame::new(driver.pose), &depths);
    gpu.queue.write_buffer(targets.get(Target::RightSource), 0, bytemuck::cast_slice(&right_source));
    driver.host += begin.elapsed();
    Ok(())
}

/// How deep the 3D buffer is, and how many rows of it fit one binding.
pub(crate) async fn size_slots(driver: &mut Driver<'_>, depth: BufferDepth) -> Result<(), Error> {
    let range = match depth {
        BufferDepth::Adaptive => depth_range(driver).await?,
        _ => (f32::INFINITY, f32::INFINITY),
    };
    let depth = depth.slots(driver.pose, range);
    let [width, height] = driver.pose.size;
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
    (driver.slot_bytes, driver.rows, driver.frame.buffer_depth) = (bytes, rows, depth);
    Ok(())
}

/// Nearest and farthest depth of the left view; the farthest is infinite as soon as one pixel is sky.
async fn depth_range(driver: &mut Driver<'_>) -> Result<(f32, f32), Error> {
    let words = counters(driver).await?;
    let rows = words.chunks_exact(layout::COUNTERS);
    Ok(rows.fold((f32::INFINITY, 0.0), |(nearest, farthest), row| {
        let far = match f32::from_bits(row[layout::FARTHEST_DEPTH]) {
            far if far >= crate::FAR => f32::INFINITY,
            far => far,
        };
        (nearest.min(f32::from_bits(row[layout::NEAREST_DEPTH])), farthest.max(far))
    }))
}

/// What the left view says of the right one's cost, and the steps that follow.
pub(crate) async fn choose(driver: &mut Driver<'_>) -> Result<Vec<Step>, Error> {
    let words = counters(driver).await?;
    let (shadow_rays, gaps) = (sum_of(&words, layout::SHADOW_RAYS), sum_of(&words, layout::GAP_PIXELS));
    let choice = CostModel::of(driver.gpu).choose(driver.pose, shadow_rays, gaps);
    log::debug!("{choice}");
    let (right, steps) = match choice.method {
        Method::Naive => (RightView::Traced, by_naive()),
        _ => (RightView::Bracketed, by_bracket()),
    };
    (driver.choice, driver.right) = (Some(choice), right);
    Ok(steps)
}

async fn counters(driver: &mut Driver<'_>) -> Result<Vec<u32>, Error> {
    driver.gpu.read(driver.targets.get(Target::Counters), driver.pose.size[1] as usize * layout::COUNTERS).await
}
