use super::{super::draws::Draws, Spec};

/// Reads a spec of one scene with more keys, as JSON text.
fn spec(keys: &str) -> Result<Spec, String> {
    let text = format!(r#"{{"pairs": 500, "scenes": [{{"builtin": "near"}}], {keys}}}"#);
    Spec::from_json(&text, ".").map_err(|error| error.to_string())
}

fn refused(keys: &str) -> String {
    spec(keys).expect_err(keys)
}

#[test]
fn options_of_rendering_are_drawn() {
    let keys = r#""render": {"samples": {"choice": [1, 4]}, "shadow_rays": {"uniform": [1, 8]},
        "method": {"choice": ["naive", "bracket"]}, "tone": "filmic"}"#;
    let spec = spec(keys).unwrap();
    let all = (0..500).map(|item| spec.options_of(&Draws { seed: 1, item, attempt: 0 }).unwrap());
    let all = Vec::from_iter(all);
    let have = |name: &str, text: &str| all.iter().filter(|options| options.get(name).unwrap() == text).count();
    assert!((200..300).contains(&have("samples", "1")) && have("samples", "1") + have("samples", "4") == 500);
    assert!((1..=8).all(|rays: u32| have("shadow_rays", &rays.to_string()) > 30));
    assert!(have("method", "naive") > 200 && have("tone", "filmic") == 500);
    // A spec that is written and read again draws the same.
    let again = Spec::from_json(&spec.to_json(), ".").unwrap();
    let draws = Draws { seed: 1, item: 7, attempt: 0 };
    assert_eq!(again.options_of(&draws).unwrap(), spec.options_of(&draws).unwrap());
}

#[test]
fn keys_that_contradict_each_other_are_refused_without_options_of_rendering() {
    let message = refused(r#""format": "kitti", "rig": {"screen_distance": 3}"#);
    assert!(message.contains("rig.screen_distance: the cameras of kitti are parallel"), "{message}");
}

#[test]
fn drawn_options_that_are_not_valid_are_refused() {
    for (keys, expected) in [
        (r#""render": {"samples": {"choice": []}}"#, "render.samples.choice: there is nothing to choose from"),
        (r#""render": {"samples": {"choice": [1, 0]}}"#, "samples"),
        (r#""render": {"samples": {"normal": 3}}"#, "render.samples.normal"),
        (r#""render": {"shadow_rays": {"uniform": [1, 99]}}"#, "shadow_rays"),
        (r#""render": {"rays": {"choice": [1]}}"#, "rays"),
        (r#""render": {"method": {"choice": ["naive", "atomic"]}}, "outputs": ["occlusion"]"#, "render.method: atomic"),
    ] {
        let message = refused(keys);
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn normal_distributions_that_are_not_valid_are_refused() {
    let normal = |numbers: &str| refused(&format!(r#""rig": {{"interaxial": {{"normal": {numbers}}}}}"#));
    for (numbers, expected) in [
        ("[0.1]", "rig.interaxial.normal: it must be [mean, deviation] or [mean, deviation, low, high]"),
        ("[0.1, 0]", "must have a deviation above 0"),
        ("[0.1, 0.1, 0.3, 0.2]", "a low and a high limit"),
        ("[0.1, 0.1]", "rig.interaxial.normal: its limit -0.5"),
        ("[0.1, 0.001, 1, 2]", "hardly any values between its limits"),
    ] {
        assert!(normal(numbers).contains(expected), "{}", normal(numbers));
    }
    spec(r#""rig": {"interaxial": {"normal": [0.1, 0.01]}}"#).unwrap();
    spec(r#""rig": {"interaxial": {"normal": [0.1, 0.1, 0.05, 0.2]}}"#).unwrap();
}
