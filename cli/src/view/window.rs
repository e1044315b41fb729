//! Handles the window's events, and schedules rendering and drawing.

use std::{
    collections::VecDeque,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use stereotrace::{Lighting, Scene, output::Batch};
use winit::{
    application::ApplicationHandler,
    dpi::{PhysicalPosition, PhysicalSize},
    event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow},
    keyboard::{KeyCode, ModifiersState, PhysicalKey},
    window::{Fullscreen, Window, WindowId},
};

use super::{
    keys::{self, Action},
    panel::Panel,
    replay::{Button, Step},
    save::{self, Origin},
    screen::{Drawn, Screen},
    settings::{Mode, Settings},
    status,
    work::{Frame, Said, Wanted, Worker},
};

/// Duration for which wiggle mode shows each eye.
const WIGGLE: Duration = Duration::from_millis(130);
/// Interval between steps of a flight.
const TICK: Duration = Duration::from_millis(16);
/// Speed of a flight, without and with Shift, in screen distances per second.
const SPEED: [f64; 2] = [0.4, 1.6];
/// Touchpad pixels that equal one step of the wheel.
const WHEEL_PIXELS: f64 = 40.0;
/// Maximum time for the window to take the size that a replay requests.
const PATIENCE: Duration = Duration::from_secs(10);

/// Number of losses in a row after which another loss of the window's device is an error.
const MOST_LOSSES: u32 = 3;

/// Input and end condition of an unattended window.
pub(super) struct Plan {
    pub(super) steps: VecDeque<Step>,
    /// Number of whole pictures after which the window closes.
    pub(super) frames: Option<u32>,
    /// File for a screenshot of the window when it closes.
    pub(super) screenshot: Option<PathBuf>,
}

/// Where and how pictures are written.
pub(super) struct Output {
    pub(super) folder: PathBuf,
    pub(super) name: String,
    pub(super) origin: Origin,
    pub(super) scene: Scene,
    pub(super) quiet: bool,
}

/// Counts and files for the summary.
#[derive(Default)]
pub(super) struct Tally {
    /// Number of drafts received, and of whole pictures shown.
    pub(super) drafts: u32,
    pub(super) whole: u32,
    /// Longest time in which the window did not respond.
    pub(super) longest: Duration,
    pub(super) files: Vec<PathBuf>,
    pub(super) fault: Option<String>,
}

pub(super) struct App {
    pub(super) tally: Tally,
    settings: Settings,
    display_width: f32,
    plan: Plan,
    output: Output,
    worker: Option<Worker>,
    screen: Option<Screen>,
    panel: Panel,
    adapter: Option<String>,
    frame: Option<Box<Frame>>,
    /// Version of the current request, and version of the last whole picture that was shown.
    version: u64,
    shown: u64,
    /// Message that is shown until the next action.
    note: Option<String>,
    text: bool,
    /// Page of the list of keys.
    help: Option<usize>,
    /// Whether to write the picture once the whole picture is ready.
    write: bool,
    /// Wiggle mode: time of the next change, and whether the right eye is shown.
    turn: (Instant, bool),
    modifiers: ModifiersState,
    buttons: Vec<Button>,
    pointer: Option<PhysicalPosition<f64>>,
    flying: Vec<(PhysicalKey, [f64; 3])>,
    tick: Instant,
    /// Number of losses of the window's device in a row.
    losses: u32,
    /// Time during the current event in which a replay's shot waited for the device. `Tally::longest` excludes it.
    excused: Duration,
    /// Time at which a replay began to wait for the window's size.
    waiting: Option<Instant>,
}

impl App {
    pub(super) fn new(
        settings: Settings,
        plan: Plan,
        output: Output,
        worker: Worker,
        (text, display_width): (bool, f32),
    ) -> Self {
        let now = Instant::now();
        Self {
            tally: Tally::default(),
            settings,
            display_width,
            plan,
            output,
            worker: Some(worker),
            screen: None,
            panel: Panel::new(1.0),
            adapter: None,
            frame: None,
            version: 0,
            shown: 0,
            note: None,
            text,
            help: None,
            write: false,
            turn: (now, false),
            modifiers: ModifiersState::empty(),
            buttons: Vec::new(),
            pointer: None,
            flying: Vec::new(),
            tick: now,
            losses: 0,
            excused: Duration::ZERO,
            waiting: None,
        }
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, fault: String) {
        self.tally.fault.get_or_insert(fault);
        event_loop.exit();
    }

    /// Opens the window, or opens its lost device again.
    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), Box<dyn std::error::Error>> {
        let window = match self.screen.take() {
            Some(old) => old.window.clone(),
            None => {
                let [width, height] = self.settings.window;
                let title = format!("{} - stereotrace", stereotrace::message::escaped(&self.output.name));
                let attributes = Window::default_attributes().with_title(title);
                let attributes = attributes.with_inner_size(PhysicalSize::new(width, height));
                Arc::new(event_loop.create_window(attributes)?)
            }
        };
        self.panel = Panel::new(window.scale_factor());
        let mut screen = Screen::new(window, event_loop.owned_display_handle())?;
        if let Some(frame) = &self.frame {
            screen.show.set_pair(&frame.pair);
        }
        self.screen = Some(screen);
        self.resize();
        Ok(())
    }

    /// Applies the window's new size to surface and settings.
    fn resize(&mut self) {
        let Some(screen) = &mut self.screen else { return };
        screen.configure();
        let (window, before) = (screen.size(), self.settings.size());
        self.settings.window = window;
        if self.settings.size() != before || self.version == 0 {
            self.change();
        }
        self.refresh();
    }

    /// Requests a picture of the current settings.
    fn change(&mut self) {
        self.version += 1;
        let size = self.settings.size();
        let (Some(worker), false) = (&self.worker, size.contains(&0)) else { return };
        worker.want(Wanted {
            version: self.version,
            camera: self.settings.camera(),
            draft: self.settings.camera_of(size),
            size,
            options: self.settings.options.clone(),
        });
    }

    /// Updates the text and requests a redraw.
    fn refresh(&mut self) {
        let frame = self.frame.as_deref();
        let rows = match self.help {
            Some(page) => {
                // A window that has grown since has fewer pages.
                let mut pages = self.pages_of_help();
                pages.swap_remove(page.min(pages.len() - 1))
            }
            None if self.text => self.panel.strip(
                &status::texts(&status::Status {
                    settings: &self.settings,
                    frame,
                    adapter: self.adapter.as_deref(),
                    is_current: frame.is_some_and(|frame| frame.version == self.version),
                    note: self.note.as_deref(),
                    display_width: self.display_width,
                }),
                self.settings.shown_size(),
            ),
            None => Vec::new(),
        };
        let text = self.panel.picture(&rows);
        let share = text.height as f32 / self.settings.shown_size()[1].max(1) as f32;
        // The head decides what is in the rows of a pair all around.
        let frame = frame.filter(|_| self.settings.head.is_none());
        let is_below = frame.is_some_and(|frame| status::is_better_below(&frame.pair, share));
        if let Some(screen) = &mut self.screen {
            screen.show.set_panel(&text, is_below);
            screen.window.request_redraw();
        }
    }

    /// Returns the list of keys in pages that fit the window.
    fn pages_of_help(&self) -> Vec<Vec<Vec<char>>> {
        let keys = status::help(self.settings.head.is_some());
        self.panel.pages(&keys, "H: more", self.settings.shown_size())
    }

    fn draw(&mut self, event_loop: &ActiveEventLoop) {
        let sight = self.settings.sight(self.turn.1);
        let Some(screen) = &mut self.screen else { return };
        match screen.draw(sight) {
            Drawn::Shown => {
                self.losses = 0;
                let Some(frame) = self.frame.as_ref().filter(|frame| frame.version == self.version) else { return };
                if frame.whole && self.shown != self.version {
                    self.shown = self.version;
                    self.tally.whole += 1;
                }
            }
            Drawn::Again => screen.window.request_redraw(),
            Drawn::Hidden => {}
            Drawn::Lost if self.losses == MOST_LOSSES => {
                self.fail(event_loop, "the window's device was lost too often".into());
            }
            Drawn::Lost => {
                self.losses += 1;
                if let Err(error) = self.open(event_loop) {
                    self.fail(event_loop, error.to_string());
                }
            }
        }
    }

    fn said(&mut self, event_loop: &ActiveEventLoop, said: Said) {
        match said {
            Said::Ready(adapter) => self.adapter = Some(adapter),
            Said::Frame(frame) => {
                if !frame.whole {
                    self.tally.drafts += 1;
                }
                if let Some(screen) = &mut self.screen {
                    screen.show.set_pair(&frame.pair);
                }
                self.frame = Some(frame);
                self.write_if_whole();
            }
            Said::Failed(_, fault) if self.frame.is_none() || self.is_automatic() => {
                return self.fail(event_loop, fault);
            }
            Said::Failed(version, _) if version != self.version => {}
            Said::Failed(_, fault) => self.note = Some(format!("error: {fault}")),
            Said::Ended(fault) => return self.fail(event_loop, fault),
        }
        self.refresh();
    }

    /// Returns whether the window is unattended, so that errors must end it.
    fn is_automatic(&self) -> bool {
        self.plan.frames.is_some()
    }

    /// Moves the eyes and requests a picture if their camera has changed. An error becomes the window's message.
    fn move_eyes(&mut self, by: impl FnOnce(&mut super::control::Place)) {
        let before = self.settings.camera();
        self.note = self.settings.move_eyes(by).err();
        if self.note.is_some() || self.settings.camera() != before {
            self.change();
        }
        self.refresh();
    }

    fn drag(&mut self, button: Button, [x, y]: [f64; 2]) {
        let height = self.settings.shown_size()[1].max(1);
        if let Some(head) = &mut self.settings.head {
            // The scene in the middle of the window follows the mouse, if the head is level.
            let angle = head.pixel(height);
            head.turn(-x * angle, y * angle);
            return self.refresh();
        }
        // A drag over the window's height is half a turn.
        let angle = std::f64::consts::PI / f64::from(height);
        match button {
            Button::Left => self.move_eyes(|place| place.orbit(-x * angle, -y * angle)),
            Button::Right => self.move_eyes(|place| place.look(-x * angle, -y * angle)),
            Button::Middle => self.move_eyes(|place| place.pan(x, y, height)),
        }
    }

    fn wheel(&mut self, steps: f64) {
        match &mut self.settings.head {
            None => self.move_eyes(|place| place.zoom(steps)),
            Some(head) => {
                head.zoom(steps);
                self.refresh();
            }
        }
    }

    fn act(&mut self, event_loop: &ActiveEventLoop, action: Action) {
        self.note = None;
        let before = (self.settings.size(), self.settings.options.clone());
        match action {
            Action::Show(mode) => self.settings.mode = mode,
            Action::NextMode => {
                let at = Mode::ALL.iter().position(|mode| *mode == self.settings.mode).unwrap_or(0);
                self.settings.mode = Mode::ALL[(at + 1) % Mode::ALL.len()];
            }
            Action::NextAnaglyph => self.settings.step_anaglyph(),
            Action::Swap => self.settings.eyes.swap = !self.settings.eyes.swap,
            Action::NextMethod { back } => self.settings.step_method(back),
            Action::Samples { fewer } => self.settings.step_samples(fewer),
            Action::Spread(factor) => return self.move_eyes(|place| place.spread(factor)),
            Action::MoveScreen(factor) => return self.move_eyes(|place| place.move_screen(factor)),
            Action::Reset => {
                self.settings.reset();
                self.change();
            }
            Action::Fullscreen => {
                if let Some(Screen { window, .. }) = &self.screen {
                    let full = window.fullscreen().is_none().then_some(Fullscreen::Borderless(None));
                    window.set_fullscreen(full);
                }
            }
            Action::Text => self.text = !self.text,
            Action::Help => {
                let next = self.help.map_or(0, |page| page + 1);
                self.help = (next < self.pages_of_help().len()).then_some(next);
            }
            Action::Write => {
                self.write = true;
                self.note = Some("the picture will be written when it is complete".into());
                self.write_if_whole();
            }
            Action::Quit => event_loop.exit(),
        }
        if before != (self.settings.size(), self.settings.options.clone()) {
            self.change();
        }
        self.refresh();
    }

    /// Writes the picture if that was requested and the whole picture is ready.
    fn write_if_whole(&mut self) {
        let version = self.version;
        let Some(frame) = self.frame.as_ref().filter(|frame| self.write && frame.whole && frame.version == version)
        else {
            return;
        };
        self.write = false;
        let Output { folder, name, origin, scene, quiet } = &self.output;
        match save::write(&self.settings, &frame.pair, folder, name) {
            Ok(path) => {
                let mut settings = self.settings.clone();
                if let (Lighting::Paths { samples, .. }, 1..) = (&mut settings.options.lighting, frame.paths) {
                    *samples = frame.paths;
                }
                let command = save::quoted(&origin.command(&settings, scene, &path));
                if !quiet {
                    use std::io::Write;
                    let _ = writeln!(std::io::stdout(), "{command}"); // a closed pipe is not an error
                }
                self.note = Some(format!("wrote {}", crate::shown(&path)));
                self.tally.files.push(path);
            }
            Err(error) => self.note = Some(format!("error: {error}")),
        }
    }

    /// Writes a screenshot of the window as PNG.
    fn shot(&mut self, path: &Path) -> Result<(), Box<dyn std::error::Error>> {
        let Some(screen) = &self.screen else { return Ok(()) };
        let begin = Instant::now();
        let picture = screen.show.picture(self.settings.sight(self.turn.1), screen.size())?;
        let mut batch = Batch::new();
        batch.add_png(path, &picture)?;
        self.tally.files.extend(batch.commit()?);
        self.excused += begin.elapsed();
        Ok(())
    }

    /// Performs the next steps of a replay until one has to wait. Closes the window at the end if --frames is given.
    fn replay(&mut self, event_loop: &ActiveEventLoop) -> Result<(), Box<dyn std::error::Error>> {
        if self.screen.is_none() {
            return Ok(());
        }
        while let Some(step) = self.plan.steps.front().cloned() {
            match step {
                Step::Wait if self.shown != self.version => return Ok(()),
                Step::Size(size) if !self.has_size(size)? => return Ok(()),
                Step::Wait | Step::Size(_) => {}
                Step::Drag(button, by) => self.drag(button, by),
                Step::Wheel(steps) => self.wheel(steps),
                Step::Fly(direction, seconds) => self.fly(direction, seconds),
                Step::Key(action) => self.act(event_loop, action),
                Step::Shot(path) => self.shot(&path)?,
                Step::LoseDevice => {
                    self.worker.iter().for_each(Worker::lose_device);
                    self.change();
                }
                Step::LoseWindow => {
                    self.screen.iter().for_each(Screen::lose_device);
                    self.change();
                }
            }
            self.plan.steps.pop_front();
        }
        let Some(frames) = self.plan.frames.filter(|_| self.shown == self.version && !self.write) else {
            return Ok(());
        };
        if self.tally.whole < frames {
            self.change();
            return Ok(());
        }
        if let Some(path) = self.plan.screenshot.take() {
            self.shot(&path)?;
        }
        event_loop.exit();
        Ok(())
    }

    /// Returns whether the window has this size, and requests the size if not.
    ///
    /// # Errors
    /// If the window does not take the size within [`PATIENCE`].
    fn has_size(&mut self, size: [u32; 2]) -> Result<bool, String> {
        let Some(screen) = &self.screen else { return Ok(false) };
        if self.settings.window == size {
            self.waiting = None;
            return Ok(true);
        }
        match self.waiting {
            Some(since) if since.elapsed() > PATIENCE => {
                let [[width, height], [w, h]] = [self.settings.window, size];
                Err(format!("the window is {width}x{height} and can't be resized to {w}x{h}"))
            }
            Some(_) => Ok(false),
            None => {
                self.waiting = Some(Instant::now());
                // If the size is set at once, no event reports it.
                if screen.window.request_inner_size(PhysicalSize::new(size[0], size[1])).is_some() {
                    self.resize();
                }
                Ok(false)
            }
        }
    }

    fn fly(&mut self, direction: [f64; 3], seconds: f64) {
        let way = seconds * SPEED[usize::from(self.modifiers.shift_key())];
        let angles = self.settings.head.map_or([0.0; 2], |head| head.angles());
        self.move_eyes(|place| place.fly_turned(direction.map(|part| part * way), angles));
    }

    fn key(&mut self, event_loop: &ActiveEventLoop, event: &KeyEvent) {
        let ctrl = self.modifiers.control_key();
        let held = self.flying.iter().position(|(key, _)| *key == event.physical_key);
        if event.state == ElementState::Released {
            held.map(|at| self.flying.remove(at));
            return;
        }
        if let (Some(direction), false) = (keys::flight(event.physical_key), ctrl) {
            if held.is_none() {
                if self.flying.is_empty() {
                    self.tick = Instant::now();
                }
                self.flying.push((event.physical_key, direction));
            }
            return;
        }
        let digit = match event.physical_key {
            PhysicalKey::Code(KeyCode::Digit1) => Some("1"),
            PhysicalKey::Code(KeyCode::Digit2) => Some("2"),
            PhysicalKey::Code(KeyCode::Digit3) => Some("3"),
            PhysicalKey::Code(KeyCode::Digit4) => Some("4"),
            PhysicalKey::Code(KeyCode::Digit5) => Some("5"),
            PhysicalKey::Code(KeyCode::Digit6) => Some("6"),
            _ => None,
        };
        let name = digit.map(str::to_owned).or_else(|| keys::name(&event.logical_key, ctrl));
        let action = name.and_then(|name| keys::action(&name, self.modifiers.shift_key()));
        let may_repeat = |action: &Action| matches!(action, Action::Spread(_) | Action::MoveScreen(_));
        if let Some(action) = action.filter(|action| !event.repeat || may_repeat(action)) {
            self.act(event_loop, action);
        }
    }

    fn button(&mut self, state: ElementState, button: MouseButton) {
        let button = match button {
            MouseButton::Left if self.modifiers.shift_key() => Button::Middle,
            MouseButton::Left => Button::Left,
            MouseButton::Right => Button::Right,
            MouseButton::Middle => Button::Middle,
            _ => return,
        };
        if state == ElementState::Pressed {
            self.buttons.push(button);
        } else {
            // Shift may have changed during the drag, so releasing any button ends all drags.
            self.buttons.clear();
        }
    }

    fn pointer(&mut self, to: PhysicalPosition<f64>) {
        let from = self.pointer.replace(to);
        if let (Some(from), Some(button)) = (from, self.buttons.last()) {
            self.drag(*button, [to.x - from.x, to.y - from.y]);
        }
    }

    fn event(&mut self, event_loop: &ActiveEventLoop, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(_) => self.resize(),
            WindowEvent::ScaleFactorChanged { scale_factor, .. } => {
                self.panel = Panel::new(scale_factor);
                self.refresh();
            }
            WindowEvent::Occluded(false) => self.refresh(),
            WindowEvent::RedrawRequested => self.draw(event_loop),
            WindowEvent::KeyboardInput { event, .. } => self.key(event_loop, &event),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::MouseInput { state, button, .. } => self.button(state, button),
            WindowEvent::CursorMoved { position, .. } => self.pointer(position),
            WindowEvent::MouseWheel { delta, .. } => {
                let steps = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / WHEEL_PIXELS,
                };
                if steps != 0.0 {
                    self.wheel(steps);
                }
            }
            WindowEvent::Focused(false) => {
                // No event reports keys and buttons that are released outside the window.
                self.flying.clear();
                self.buttons.clear();
            }
            _ => {}
        }
    }

    /// Advances replay, flight and wiggle. Returns when to wake up next.
    fn go_on(&mut self, event_loop: &ActiveEventLoop) -> ControlFlow {
        if let Err(error) = self.replay(event_loop) {
            self.fail(event_loop, error.to_string());
        }
        let now = Instant::now();
        let mut next: Option<Instant> = self.waiting.map(|since| since + PATIENCE + TICK);
        let mut wake = |at: Instant| next = Some(next.map_or(at, |next| next.min(at)));
        if !self.flying.is_empty() {
            if now >= self.tick + TICK {
                let sum = self.flying.iter().fold([0.0; 3], |sum, (_, by)| [0, 1, 2].map(|axis| sum[axis] + by[axis]));
                // A long pause of the window must not cause a long jump of the eyes.
                let seconds = (now - self.tick).min(Duration::from_millis(250)).as_secs_f64();
                self.tick = now;
                self.fly(sum, seconds);
            }
            wake(self.tick + TICK);
        }
        if self.settings.mode == Mode::Wiggle {
            if now >= self.turn.0 {
                self.turn = (now + WIGGLE, !self.turn.1);
                self.screen.iter().for_each(|screen| screen.window.request_redraw());
            }
            wake(self.turn.0);
        }
        next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil)
    }

    /// Runs `work` and records how long the window did not respond.
    fn timed<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let begin = Instant::now();
        self.excused = Duration::ZERO;
        let done = work(self);
        self.tally.longest = self.tally.longest.max(begin.elapsed().saturating_sub(self.excused));
        done
    }
}

impl ApplicationHandler<Said> for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.screen.is_none()
            && let Err(error) = self.open(event_loop)
        {
            self.fail(event_loop, format!("the window can't be opened: {error}"));
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, said: Said) {
        self.timed(|app| app.said(event_loop, said));
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        self.timed(|app| app.event(event_loop, event));
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let control = self.timed(|app| app.go_on(event_loop));
        event_loop.set_control_flow(control);
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The window closes first, since the thread may take a while to end.
        self.screen = None;
        self.worker = None;
    }
}
