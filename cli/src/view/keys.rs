//! Maps keys to actions.

use winit::keyboard::{Key, KeyCode, NamedKey, PhysicalKey};

use super::settings::Mode;

/// Action of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Action {
    Show(Mode),
    NextMode,
    NextAnaglyph,
    Swap,
    NextMethod {
        back: bool,
    },
    Samples {
        fewer: bool,
    },
    /// Multiplies the interaxial by this factor.
    Spread(f64),
    /// Multiplies the screen distance by this factor.
    MoveScreen(f64),
    Reset,
    Fullscreen,
    Text,
    Help,
    Write,
    Quit,
}

/// Factors of interaxial and screen distance for one step, and for a fine step.
const STEP: f64 = 1.1;
const FINE: f64 = 1.01;

/// Keys and their descriptions, as the window lists them.
pub(super) const HELP: [(&str, &str); 19] = [
    ("left drag", "orbit around the middle of the screen"),
    ("right drag", "look around"),
    ("middle drag", "move sideways (also Shift and left drag)"),
    ("wheel", "move nearer or farther"),
    ("W A S D Q E", "fly (keys by position); with Shift faster"),
    ("arrows < >", "interaxial smaller or larger; with Shift finer"),
    ("arrows ^ v", "screen distance larger or smaller; with Shift finer"),
    ("1 to 6", "anaglyph, side by side, cross-eyed, wiggle, left, right"),
    ("V", "next of these modes"),
    ("G", "next glasses"),
    ("X", "swap the eyes"),
    ("M", "next method; with Shift the previous one"),
    ("+ -", "more or fewer samples"),
    ("R", "reset"),
    ("P, Ctrl+S", "write the picture, and print the command that makes it"),
    ("F, F11", "full screen on or off"),
    ("T", "text on or off"),
    ("H, F1", "this list; again for more of it, or off"),
    ("Esc", "end"),
];

/// Keys and their descriptions for equirectangular pairs, in place of the first ones of [`HELP`].
pub(super) const HELP_AROUND: [(&str, &str); 6] = [
    ("drag", "turn the head"),
    ("wheel", "narrower or wider field of view"),
    ("W A S D Q E", "fly (keys by position); with Shift faster"),
    ("arrows < >", "interaxial smaller or larger; with Shift finer"),
    ("arrows ^ v", "distance without parallax larger or smaller"),
    ("1 to 6", "anaglyph, side by side, cross-eyed, wiggle, left, right"),
];

/// Returns the action of a key by its name: a character, or a name such as `left`, `f1` or `ctrl+s`.
pub(super) fn action(name: &str, shift: bool) -> Option<Action> {
    let step = if shift { FINE } else { STEP };
    Some(match name {
        "v" | "tab" => Action::NextMode,
        "g" => Action::NextAnaglyph,
        "x" => Action::Swap,
        "m" => Action::NextMethod { back: shift },
        "+" | "=" => Action::Samples { fewer: false },
        "-" | "_" => Action::Samples { fewer: true },
        "left" => Action::Spread(1.0 / step),
        "right" => Action::Spread(step),
        "up" => Action::MoveScreen(step),
        "down" => Action::MoveScreen(1.0 / step),
        "r" => Action::Reset,
        "f" | "f11" => Action::Fullscreen,
        "t" => Action::Text,
        "h" | "f1" => Action::Help,
        "p" | "ctrl+s" => Action::Write,
        "escape" => Action::Quit,
        _ => {
            let digit: usize = name.parse().ok()?;
            Action::Show(*Mode::ALL.get(digit.checked_sub(1)?)?)
        }
    })
}

/// Returns a key's name, as [`action`] reads it.
pub(super) fn name(key: &Key, ctrl: bool) -> Option<String> {
    let name = match key {
        Key::Character(text) => text.to_lowercase(),
        Key::Named(NamedKey::ArrowLeft) => "left".into(),
        Key::Named(NamedKey::ArrowRight) => "right".into(),
        Key::Named(NamedKey::ArrowUp) => "up".into(),
        Key::Named(NamedKey::ArrowDown) => "down".into(),
        Key::Named(NamedKey::Escape) => "escape".into(),
        Key::Named(NamedKey::Tab) => "tab".into(),
        Key::Named(NamedKey::F1) => "f1".into(),
        Key::Named(NamedKey::F11) => "f11".into(),
        _ => return None,
    };
    Some(if ctrl { format!("ctrl+{name}") } else { name })
}

/// Returns the direction that a held key flies in: right, up and ahead. The direction depends on the key's position, so
/// that the layout is the same on all keyboards.
pub(super) fn flight(key: PhysicalKey) -> Option<[f64; 3]> {
    let PhysicalKey::Code(code) = key else { return None };
    let letter = match code {
        KeyCode::KeyW => 'w',
        KeyCode::KeyS => 's',
        KeyCode::KeyA => 'a',
        KeyCode::KeyD => 'd',
        KeyCode::KeyE => 'e',
        KeyCode::KeyQ => 'q',
        _ => return None,
    };
    flight_of(letter)
}

/// Returns the direction by the key's letter on a QWERTY keyboard.
pub(super) fn flight_of(letter: char) -> Option<[f64; 3]> {
    Some(match letter {
        'w' => [0.0, 0.0, 1.0],
        's' => [0.0, 0.0, -1.0],
        'a' => [-1.0, 0.0, 0.0],
        'd' => [1.0, 0.0, 0.0],
        'e' => [0.0, 1.0, 0.0],
        'q' => [0.0, -1.0, 0.0],
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_keys_are_those_that_do_something() {
        let named = [NamedKey::ArrowLeft, NamedKey::ArrowRight, NamedKey::ArrowUp, NamedKey::ArrowDown];
        let more = [NamedKey::Escape, NamedKey::Tab, NamedKey::F1, NamedKey::F11];
        for key in named.into_iter().chain(more) {
            let name = name(&Key::Named(key), false).unwrap();
            assert!(action(&name, false).is_some(), "{name}");
        }
        assert_eq!(name(&Key::Character("S".into()), true).as_deref(), Some("ctrl+s"));
        assert_eq!(action("ctrl+s", false), Some(Action::Write));
        for (digit, mode) in ["1", "2", "3", "4", "5", "6"].into_iter().zip(Mode::ALL) {
            assert_eq!(action(digit, false), Some(Action::Show(mode)));
        }
        for nothing in ["0", "7", "", "s", "w", "ctrl+p", "-1"] {
            assert_eq!(action(nothing, false), None, "{nothing}");
        }
    }

    #[test]
    fn keys_that_fly_do_nothing_else() {
        for letter in "wasdqe".chars() {
            assert!(flight_of(letter).is_some() && action(&letter.to_string(), false).is_none(), "{letter}");
        }
    }
}
