//! Tests the messages of `stereotrace view` where no window can be opened. `scripts/check_view.sh` tests the window.

mod common;

use common::error_of;

#[cfg(not(feature = "view"))]
#[test]
fn a_build_without_windows_says_how_to_get_one() {
    for arguments in [&["view"][..], &["view", "bunny.obj", "--size", "320x240", "--replay", "x"]] {
        let message = error_of(arguments);
        assert_eq!(message, "view: this build has no window; build the command with its default features to get one");
    }
}

#[cfg(feature = "view")]
mod with_windows {
    use super::{
        common::{folder::Folder, run},
        error_of,
    };

    #[test]
    fn faults_are_said_before_a_window_opens() {
        let folder = Folder::new("view");
        let replay = folder.write("steps", "wait # for it\n\njump 3\n");
        let replay = replay.to_str().unwrap();
        assert!(
            error_of(&["view", "--replay", replay])
                .ends_with("steps:3: unknown step; use wait, drag, wheel, fly, key, size, shot or lose")
        );
        assert!(error_of(&["view", "--replay", folder.path().to_str().unwrap()]).contains("a file of at most 1 MiB"));
        assert!(error_of(&["view", "--size", "100000x2"]).starts_with("--size 100000x2: a window has at most 16384"));
        for arguments in [&["--frames", "0"][..], &["--screenshot", "a.png"], &["--display-width", "0"]] {
            let output = run(&[&["view"], arguments].concat());
            assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn without_a_display_there_is_one_line() {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_stereotrace"))
            .args(["view", "builtin:hall"])
            .env("NODEVICE_SELECT", "1")
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .output()
            .unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), text.lines().count()), (Some(1), 1), "{text}");
        assert!(text.starts_with("error: no window can be opened: "), "{text}");
    }
}
