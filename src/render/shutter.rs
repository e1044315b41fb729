//! Motion blur: the mean of a pair's pictures at several times while the shutter is open.

use crate::{Error, Options, StereoPair, View};

/// Sums of the pictures of one pair at several times while its shutter is open. The times divide this interval evenly
/// ([`MotionBlur::offsets`]). The ground truth of a blurred pair is that of the middle of the interval.
///
/// ```
/// use stereotrace::{Builtin, Gpu, MotionBlur, Options, Renderer, blocking::Wait};
///
/// let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(64, 48));
/// let mut renderer = Renderer::new(Gpu::new().wait()?);
/// let uploaded = renderer.upload(&scene).wait()?;
/// let options = Options::default().linear(true);
/// let mut pair = renderer.pair(&uploaded, &camera).options(&options).read().wait()?;
/// let mut blur = MotionBlur::new();
/// for offset in MotionBlur::offsets(0.5, 4) {
///     let turned = camera.orbited(0.1 * offset as f32);
///     blur.add(&renderer.pair(&uploaded, &turned).options(&options).read().wait()?)?;
/// }
/// blur.apply(&mut pair, &options)?;
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct MotionBlur {
    /// Sums of linear light of the left and the right view, row-major.
    sums: [Vec<[f64; 3]>; 2],
    count: u32,
}

impl MotionBlur {
    /// Creates sums without pictures.
    pub fn new() -> Self {
        Self::default()
    }

    /// Usual number of times.
    pub const TIMES: u32 = 16;
    /// Maximum number of times that the command and data sets accept.
    pub const MOST_TIMES: u32 = 256;

    /// Returns the [`MotionBlur::offsets`], each with options that place samples elsewhere in their pixels.
    pub fn instants(open: f64, times: u32, options: &Options) -> impl Iterator<Item = (f64, Options)> {
        let options_of = |number| options.clone().seed(options.seed.wrapping_add(number));
        (1..).zip(Self::offsets(open, times)).map(move |(number, offset)| (offset, options_of(number)))
    }

    /// Returns `times` offsets from the middle of an interval of length `open`, in the same unit. They are the middles
    /// of equal parts of the interval.
    pub fn offsets(open: f64, times: u32) -> impl Iterator<Item = f64> {
        (0..times).map(move |time| open * ((f64::from(time) + 0.5) / f64::from(times) - 0.5))
    }

    /// Returns the number of pictures.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Adds the pictures of one time.
    ///
    /// # Errors
    /// [`Error::Options`] for a pair without linear light ([`Options::linear`]), or of another size than the pairs
    /// before.
    pub fn add(&mut self, pair: &StereoPair) -> Result<(), Error> {
        self.check(pair)?;
        for (sums, view) in self.sums.iter_mut().zip([&pair.left, &pair.right]) {
            sums.resize(view.linear.len(), [0.0; 3]);
            for (sum, color) in sums.iter_mut().zip(&view.linear) {
                sum.iter_mut().zip(color).for_each(|(sum, value)| *sum += f64::from(*value));
            }
        }
        self.count += 1;
        Ok(())
    }

    /// Replaces the pair's colours by the mean of the pictures, shown with the exposure and tone mapping of `options`.
    /// It leaves the pair's depths, ids and other data as they are. Without any picture, nothing changes.
    ///
    /// # Errors
    /// [`Error::Options`] for a pair of another size than the pictures.
    pub fn apply(&self, pair: &mut StereoPair, options: &Options) -> Result<(), Error> {
        if self.count == 0 {
            return Ok(());
        }
        self.check(pair)?;
        for (sums, view) in self.sums.iter().zip([&mut pair.left, &mut pair.right]) {
            let mean = |sum: &[f64; 3]| sum.map(|sum| (sum / f64::from(self.count)) as f32);
            view.show_linear(sums.iter().map(mean), options);
        }
        Ok(())
    }

    fn check(&self, pair: &StereoPair) -> Result<(), Error> {
        let fault = |reason: &str| Err(Error::Options { option: "motion blur", reason: reason.into() });
        let fits = |view: &View, sums: &Vec<_>| self.count == 0 || view.linear.len() == sums.len();
        if [&pair.left, &pair.right].iter().any(|view| view.linear.is_empty()) {
            return fault("it needs linear light; use Options::linear(true)");
        }
        if !fits(&pair.left, &self.sums[0]) || !fits(&pair.right, &self.sums[1]) {
            return fault("the pictures have different sizes");
        }
        Ok(())
    }
}
