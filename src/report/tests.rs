use crate::blocking::Wait;

use super::*;

fn small_plan() -> ReportPlan {
    ReportPlan {
        scenes: vec![Builtin::Spheres, Builtin::Near],
        sizes: vec![[48, 32], [96, 64]],
        methods: vec![Method::BRACKET, Method::ES_ISLER, Method::Auto, Method::Naive],
        rounds: 2,
        most: Duration::from_secs(3600),
    }
}

fn measured(plan: &ReportPlan) -> Report {
    Report::measure(&Gpu::under_test(), plan, &mut |_| ControlFlow::Continue(())).wait().unwrap()
}

#[test]
fn a_report_has_what_its_plan_says() {
    let report = measured(&small_plan());
    let of = Vec::from_iter(report.entries.iter().map(|entry| (entry.scene, entry.size)));
    let (spheres, near) = (Builtin::Spheres, Builtin::Near);
    assert_eq!(of, [(spheres, [48, 32]), (near, [48, 32]), (spheres, [96, 64]), (near, [96, 64])]);
    assert_eq!((report.left_out.len(), report.faults()), (0, Vec::new()));
    for entry in &report.entries {
        let methods = Vec::from_iter(entry.methods.iter().map(|row| row.method));
        assert_eq!(methods, [Method::Naive, Method::Ideal, Method::BRACKET, Method::ES_ISLER, Method::Auto]);
        let [naive, ideal, bracket, es_isler, auto] = &entry.methods[..] else { unreachable!("five methods") };
        let pixels = u64::from(entry.size[0] * entry.size[1]);
        assert_eq!(naive.rays.map(|rays| rays.primary), [pixels; 2]);
        assert_eq!((naive.identical_percent, naive.retraced, naive.work.submissions), (100.0, 1.0, 1));
        assert!(ideal.identical_percent < 100.0 && ideal.rays[1].total() == 0);
        assert_eq!(bracket.wrong_surface_percent, 0.0);
        assert!(es_isler.wrong_surface_percent > 0.0 && es_isler.retraced < 0.6);
        assert!(auto.chosen.is_some() && naive.chosen.is_none());
        assert!(entry.methods.iter().all(|row| row.range[0] <= row.pair && row.pair <= row.range[1]));
        assert!((ideal.second_eye.abs() < 1e-9) && entry.has_known_ids.is_none());
    }
    // The smaller picture of a scene has other ids.
    assert_ne!(report.entries[0].ids, report.entries[2].ids);
}

#[test]
fn what_takes_too_long_is_left_out_and_said() {
    let plan = ReportPlan { most: Duration::ZERO, ..small_plan() };
    let report = measured(&plan);
    assert_eq!((report.entries.len(), report.left_out.len()), (0, 4));
    assert!(report.to_html().contains("Left out for lack of time: near at 96x64."));
    let stopped = Report::measure(&Gpu::under_test(), &plan, &mut |_| ControlFlow::Break(())).wait();
    assert!(matches!(stopped, Err(Error::Cancelled)));
}

#[test]
fn a_wrong_surface_is_a_fault_of_methods_that_promise_none() {
    let mut report = measured(&ReportPlan { scenes: vec![Builtin::Near], sizes: vec![[48, 32]], ..small_plan() });
    assert!(report.faults().is_empty());
    report.entries[0].methods[2].wrong_surface_percent = 0.25;
    let fault = "near at 48x32: bracket shows another surface in 0.2500% of pixels";
    assert_eq!(report.faults(), [fault]);
    report.adapter = "<i>A & B</i>".into();
    let page = report.to_html();
    assert!(page.contains(fault) && page.contains("&lt;i&gt;A &amp; B&lt;/i&gt;") && !page.contains("<i>A"));
}

#[cfg(feature = "json")]
#[test]
fn the_json_form_has_the_figures_of_the_report() {
    let report = measured(&ReportPlan { sizes: vec![[48, 32]], ..small_plan() });
    let json: serde_json::Value = serde_json::from_str(&report.to_json()).unwrap();
    assert_eq!(json["adapter"], report.adapter);
    assert_eq!(json["limits"]["max_texture_dimension_2d"], Gpu::under_test().limits.max_texture_dimension_2d);
    let (entry, row) = (&report.entries[1], &report.entries[1].methods[2]);
    let [scene, method] = [&json["scenes"][1], &json["scenes"][1]["methods"][2]];
    assert_eq!([&scene["scene"], &method["method"]], ["near", "bracket"]);
    assert_eq!(scene["ids"], format!("{:016x}", entry.ids));
    assert_eq!(method["pair_ms"], 1e3 * row.pair.as_secs_f64());
    assert_eq!(method["rays"]["right"]["shadow"], row.rays[1].shadow);
    assert_eq!(method["submissions"], 1);
    let page = Report { adapter: "</script>".into(), ..report }.to_html();
    let inside = page.split("id=\"report\">").nth(1).and_then(|rest| rest.split("</script>").next()).unwrap();
    assert_eq!(serde_json::from_str::<serde_json::Value>(inside).unwrap()["adapter"], "</script>");
}

#[test]
fn the_ids_of_a_software_adapter_are_known() {
    let mut renderer = Renderer::new(Gpu::under_test());
    if !renderer.gpu().is_exact() {
        return;
    }
    let plan = ReportPlan::default();
    for builtin in plan.scenes {
        let mut scene = builtin.scene();
        scene.lights.clear(); // they change no ids
        let [width, height] = plan.sizes[0];
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let options = crate::Options::new(Method::Naive).bounces(0);
        let pair = renderer.pair(&uploaded, &builtin.camera(width, height)).options(&options).read().wait().unwrap();
        let ids = measure::hash_of(pair.left.primitive.iter().chain(&pair.right.primitive));
        assert_eq!(measure::known_ids(builtin, [width, height]), Some(ids), "{builtin}");
    }
}
