//! Reads input events from a file, for tests and demonstrations. The window handles them like mouse and key input.
//!
//! Each line is a step, and `#` begins a comment:
//!
//! ```text
//! wait                    until the whole picture is shown
//! drag left 120 -30       a drag by a button (left, right, middle), right and down in pixels
//! wheel 2                 steps of the wheel, nearer
//! fly w 0.5               a key (w, a, s, d, q, e) held for so many seconds
//! key m                   a key by its name: a character, left, right, up, down, f1, tab, escape, ctrl+s;
//!                         shift+ before it
//! size 640x360            the window's size in pixels
//! shot FILE               what the window shows, as PNG
//! lose device             take the renderer's device away, or the window's: lose window
//! ```

use std::{collections::VecDeque, fs, path::Path, path::PathBuf};

use super::keys::{Action, action, flight_of};
use crate::{arguments::size, shown};

/// Maximum size of the file.
const MOST_BYTES: u64 = 1 << 20;

/// Mouse button of a drag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Button {
    Left,
    Right,
    Middle,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    Wait,
    Drag(Button, [f64; 2]),
    Wheel(f64),
    /// Direction of the key, and duration in seconds.
    Fly([f64; 3], f64),
    Key(Action),
    Size([u32; 2]),
    Shot(PathBuf),
    LoseDevice,
    LoseWindow,
}

/// Reads the steps of a file.
pub(super) fn read(path: &Path) -> Result<VecDeque<Step>, String> {
    let fault = |error: &dyn std::fmt::Display| format!("{}: {error}", shown(path));
    let data = fs::metadata(path).map_err(|error| fault(&error))?;
    if !data.is_file() || data.len() > MOST_BYTES {
        return Err(fault(&"it must be a file of at most 1 MiB"));
    }
    let text = fs::read_to_string(path).map_err(|error| fault(&error))?;
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.split('#').next().unwrap_or_default()));
    let lines = lines.filter(|(_, line)| !line.trim().is_empty());
    lines.map(|(number, line)| step(line).map_err(|error| format!("{}:{number}: {error}", shown(path)))).collect()
}

fn step(line: &str) -> Result<Step, String> {
    let words = Vec::from_iter(line.split_whitespace());
    let number = |word: &str| {
        let number = word.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| format!("{} is not a number", stereotrace::message::escaped(word)))
    };
    Ok(match *words {
        ["wait"] => Step::Wait,
        ["drag", button, x, y] => Step::Drag(self::button(button)?, [number(x)?, number(y)?]),
        ["wheel", steps] => Step::Wheel(number(steps)?),
        ["fly", key, seconds] => {
            let direction = key.parse().ok().and_then(flight_of).ok_or("the key must be w, a, s, d, q or e")?;
            Step::Fly(direction, number(seconds)?)
        }
        ["key", name] => {
            let (plain, shift) = name.strip_prefix("shift+").map_or((name, false), |name| (name, true));
            Step::Key(action(plain, shift).ok_or("the key has no action")?)
        }
        ["size", size] => Step::Size(self::size(size)?),
        ["shot", file] => Step::Shot(file.into()),
        ["lose", "device"] => Step::LoseDevice,
        ["lose", "window"] => Step::LoseWindow,
        _ => return Err("unknown step; use wait, drag, wheel, fly, key, size, shot or lose".into()),
    })
}

fn button(name: &str) -> Result<Button, String> {
    match name {
        "left" => Ok(Button::Left),
        "right" => Ok(Button::Right),
        "middle" => Ok(Button::Middle),
        _ => Err("the button must be left, right or middle".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_read_and_faults_say_what_is_wrong() {
        assert_eq!(step("drag left 3 -4.5"), Ok(Step::Drag(Button::Left, [3.0, -4.5])));
        assert_eq!(step("key shift+m"), Ok(Step::Key(Action::NextMethod { back: true })));
        assert_eq!(step("fly w 0.5"), Ok(Step::Fly([0.0, 0.0, 1.0], 0.5)));
        assert_eq!(step("size 64x32"), Ok(Step::Size([64, 32])));
        for line in
            ["jump", "wait 3", "drag left 3", "drag up 3 4", "fly x 1", "wheel NaN", "key s", "size 3", "lose all"]
        {
            assert!(step(line).is_err(), "{line}");
        }
    }
}
