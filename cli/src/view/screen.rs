//! Draws into the window's surface with its own device. The rendering thread uses another device, so neither device
//! waits for the other.

use std::{
    error::Error,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use stereotrace::{
    Gpu,
    wgpu::{self, CurrentSurfaceTexture, TextureFormat},
};
use winit::{event_loop::OwnedDisplayHandle, window::Window};

use super::show::{Show, Sight};

/// Surface formats in order of preference. They take encoded colours as they are.
const FORMATS: [TextureFormat; 2] = [TextureFormat::Bgra8Unorm, TextureFormat::Rgba8Unorm];

/// Number of failures in a row above which the device counts as lost, since not every driver reports a loss.
const PATIENCE: u32 = 8;

/// Result of drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drawn {
    Shown,
    /// The picture must be drawn again.
    Again,
    /// The window is not visible.
    Hidden,
    /// The device is lost, and a new screen is needed.
    Lost,
}

pub(super) struct Screen {
    pub(super) window: Arc<Window>,
    pub(super) show: Show,
    instance: wgpu::Instance,
    device: wgpu::Device,
    queue: wgpu::Queue,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    lost: Arc<AtomicBool>,
    /// Number of failures in a row.
    failures: u32,
}

impl Screen {
    /// Opens a device that can draw into a window.
    pub(super) fn new(window: Arc<Window>, display: OwnedDisplayHandle) -> Result<Self, Box<dyn Error>> {
        let descriptor = wgpu::InstanceDescriptor::new_with_display_handle_from_env(Box::new(display));
        let instance = wgpu::Instance::new(descriptor);
        let surface = instance.create_surface(window.clone())?;
        let options = wgpu::RequestAdapterOptions { compatible_surface: Some(&surface), ..Default::default() };
        let adapter = pollster::block_on(instance.request_adapter(&options))
            .map_err(|error| format!("no adapter can draw into this window: {error}"))?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("window"),
            required_features: Gpu::required_features(),
            required_limits: Gpu::required_limits().using_resolution(adapter.limits()),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
        let lost = Arc::new(AtomicBool::new(false));
        let (flag, wake) = (lost.clone(), Arc::downgrade(&window));
        device.set_device_lost_callback(move |reason, message| {
            // This callback also runs when the device is dropped, but then the flag is not read.
            log::info!("the window's device was lost ({reason:?}): {message}");
            flag.store(true, Ordering::Relaxed);
            if let Some(window) = wake.upgrade() {
                window.request_redraw();
            }
        });
        device.on_uncaptured_error(Arc::new(|error| log::error!("window: {error}")));

        let offered = surface.get_capabilities(&adapter).formats;
        let format = FORMATS.into_iter().find(|format| offered.contains(format));
        let format = format.ok_or("the window supports neither Bgra8Unorm nor Rgba8Unorm")?;
        let mut config = surface.get_default_config(&adapter, 1, 1).ok_or("the adapter can't draw into this window")?;
        (config.format, config.present_mode) = (format, wgpu::PresentMode::AutoVsync);
        let show = Show::new(Gpu::from_device(device.clone(), queue.clone())?, format);
        let mut screen = Self { window, show, instance, device, queue, surface, config, lost, failures: 0 };
        screen.configure();
        Ok(screen)
    }

    /// Returns the window's size in pixels, at most the maximum size of a texture. A side is 0 if the window is
    /// minimised.
    pub(super) fn size(&self) -> [u32; 2] {
        let (size, most) = (self.window.inner_size(), self.device.limits().max_texture_dimension_2d);
        [size.width.min(most), size.height.min(most)]
    }

    /// Fits the surface to the window, unless the window has no pixels.
    pub(super) fn configure(&mut self) {
        let [width, height] = self.size();
        if width > 0 && height > 0 {
            (self.config.width, self.config.height) = (width, height);
            self.surface.configure(&self.device, &self.config);
        }
    }

    /// Draws the pair and presents it.
    pub(super) fn draw(&mut self, sight: Sight) -> Drawn {
        if self.lost.load(Ordering::Relaxed) || self.failures > PATIENCE {
            return Drawn::Lost;
        }
        if self.size().contains(&0) {
            return Drawn::Hidden;
        }
        let (texture, fits) = match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(texture) => (texture, true),
            CurrentSurfaceTexture::Suboptimal(texture) => (texture, false),
            CurrentSurfaceTexture::Timeout => return Drawn::Again,
            CurrentSurfaceTexture::Occluded => return Drawn::Hidden,
            CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Validation => return self.configure_again(),
            CurrentSurfaceTexture::Lost => {
                match self.instance.create_surface(self.window.clone()) {
                    Ok(surface) => self.surface = surface,
                    Err(_) => return Drawn::Lost,
                }
                return self.configure_again();
            }
        };
        if let Err(error) = self.show.draw(sight, &texture.texture) {
            log::error!("window: {error}");
            drop(texture);
            return self.configure_again();
        }
        self.window.pre_present_notify();
        self.queue.present(texture);
        self.failures = 0;
        if !fits {
            self.configure();
        }
        Drawn::Shown
    }

    fn configure_again(&mut self) -> Drawn {
        let _ = self.device.poll(wgpu::PollType::Poll); // runs the callback of a lost device
        if self.lost.load(Ordering::Relaxed) {
            return Drawn::Lost;
        }
        self.failures += 1;
        self.configure();
        Drawn::Again
    }

    /// Destroys the device, for tests.
    pub(super) fn lose_device(&self) {
        self.device.destroy();
    }
}
