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

#[test]
fn lenses_are_fixed_or_drawn() {
    let spec = spec(
        r#""rig": {"lens": {"fx": {"uniform": [400, 500]}, "cy": 230,
        "radial_tangential": [{"uniform": [-0.2, 0.0]}, 0.03, 0.001, 0]}}"#,
    )
    .unwrap();
    let names = Vec::from_iter(spec.arrays().iter().map(|array| array.output.name()));
    assert_eq!(names, ["color", "color", "match", "match", "match_visibility", "match_visibility"]);
    let again = Spec::from_json(&spec.to_json(), ".").unwrap();
    let drawn = |spec: &Spec, item| {
        spec.rig.lens.as_ref().unwrap().drawn(&Draws { seed: 1, item, attempt: 0 }, [640, 480]).unwrap()
    };
    let all = Vec::from_iter((0..50).map(|item| drawn(&spec, item)));
    assert!(all.iter().all(|lens| (400.0..=500.0).contains(&lens.fx) && lens.fx == lens.fy));
    assert!(all.iter().all(|lens| [lens.cx, lens.cy] == [320.0, 230.0]) && all[0] != all[1]);
    assert_eq!(drawn(&again, 7), all[7]);
}

#[test]
fn lenses_that_cannot_be_rendered_are_refused_by_key() {
    let lens = |more: &str| refused(&format!(r#""rig": {{"lens": {{"fx": 400{more}}}}}"#));
    assert!(lens(r#", "fisheye": [0, 0]"#).contains("rig.lens.fisheye: 2 coefficients must be 4"));
    assert!(lens(r#", "radial_tangential": [0, 0, 0]"#).contains("3 coefficients must be 4, 5 or 8"));
    assert!(lens(r#", "k1": 0"#).contains("rig.lens: unknown key 'k1'"));
    assert!(lens(r#", "fisheye": [0, 0, 0, 0], "radial_tangential": [0, 0, 0, 0]"#).contains("give one of them"));
    assert!(lens(r#", "radial_tangential": [-0.9, 0, 0, 0]"#).contains("folds at pixel"));
    assert!(refused(r#""rig": {"lens": {"cx": 3}}"#).contains("rig.lens.fx"));
    let rig = |more: &str| refused(&format!(r#""rig": {{"lens": {{"fx": 400}}, {more}}}"#));
    assert!(rig(r#""fov": 40"#).contains("rig.fov: eyes with a lens are parallel"));
    assert!(rig(r#""projection": 360"#).contains("rig.projection"));
    let with = |more: &str| refused(&format!(r#""rig": {{"lens": {{"fx": 400}}}}, {more}"#));
    assert!(with(r#""render": {"method": "bracket"}"#).contains("render.method: bracket reuses rows"));
    assert!(with(r#""format": "kitti""#).contains("the pairs of kitti are rectified"));
    assert!(with(r#""outputs": ["disparity"]"#).contains("use match and match_visibility"));
    assert!(with(r#""outputs": ["layer_depth"]"#).contains("use match and match_visibility"));
    let rolling = r#""motion": {"rolling": {"readout": 1}}, "outputs": ["color"]"#;
    assert!(with(rolling).contains("motion.rolling: its bands are for planar"));
    spec(r#""rig": {"lens": {"fx": 400}}, "motion": {}, "outputs": ["flow"]"#).unwrap();
    // Pairs without a lens have matches too.
    spec(r#""outputs": ["match", "left.match_visibility"]"#).unwrap();
}
