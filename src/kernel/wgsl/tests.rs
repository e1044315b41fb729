//! Tests of the linker.

use super::*;

fn part(text: &'static str) -> Part {
    Part { file: "some.wgsl", text }
}

/// Returns the names that the first definition of a text uses, without keywords and types of WGSL.
fn uses(text: &'static str) -> Vec<&'static str> {
    let mut used = definitions(part(text)).remove(0).uses;
    used.retain(|word| !["case", "const", "fn", "let", "return", "struct", "switch", "u32", "var"].contains(word));
    used
}

#[test]
fn definitions_are_found_by_name_and_line() {
    let text = "// fn none() {}\nstruct A { x: f32 }\n\nalias F = vec4<bool>;\nvar<storage, read> b: array<A>;\n\
                const C: u32 = (1u + 2u); override D: bool = false;\n@compute @workgroup_size(8, 8)\n\
                fn e(id: vec3u) -> u32 {\n    if true { return 1u; }\n}\nvar<private> g: F;";
    let found: Vec<_> = definitions(part(text)).into_iter().map(|found| (found.name, found.line)).collect();
    assert_eq!(found, [("A", 2), ("F", 4), ("b", 5), ("C", 6), ("D", 6), ("e", 7), ("g", 11)]);
}

#[test]
fn comments_members_numbers_and_a_definition_s_own_names_are_not_used() {
    assert_eq!(uses("// shade()\nconst A: u32 = B; // sky()"), ["B"]);
    assert_eq!(uses("fn f() { return hit.depth.x + 1e-3 * 0x1fu; }"), ["f", "hit"]);
    assert_eq!(uses("struct S { sky: F, @align(16) lights: U }"), ["F", "S", "U", "align"]);
    let text = "fn f(tile: Tile) { let block = tile; var<function> a: A; var b = block; const C = b; }";
    assert_eq!(uses(text), ["A", "Tile", "f", "function"]);
    assert_eq!(uses("fn f() { switch x { case A, B: {} default: {} } }"), ["A", "B", "f", "x"]);
}

#[test]
fn sections_end_at_the_next_one_at_an_end_and_with_the_file() {
    let text = "const A = 1;\n//! if sky is map\nconst B = 1;\n//! if sky is constant or gradient\nconst C = 1;\n\
                //! end\n\
                const D = 1;\n//! if sky is map and lights is none\nconst E = 1;";
    let found = definitions(part(text));
    let when = |name| found.iter().find(|found| found.name == name).unwrap().when.clone();
    let condition = |choice, values: &[&'static str]| Condition { choice, values: values.to_vec() };
    assert_eq!((when("A"), when("D")), (vec![], vec![]));
    assert_eq!(when("B"), [condition("sky", &["map"])]);
    assert_eq!(when("C"), [condition("sky", &["constant", "gradient"])]);
    assert_eq!(when("E"), [condition("sky", &["map"]), condition("lights", &["none"])]);
    assert!(when("C")[0].holds(&[("lights", "none"), ("sky", "gradient")]));
    assert!(!when("C")[0].holds(&[("lights", "gradient"), ("sky", "map")]));
}

#[test]
fn every_line_of_a_text_is_told_by_file_and_line() {
    let main = Part { file: "main.wgsl", text: "// A head.\n\nfn main() { let x = pixel_index(vec2u(0u)); }\n" };
    let text = linked(main, &[]).text;
    for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.starts_with("// ")) {
        let origin = origin(&text, index + 1).unwrap();
        let (file, number) = origin.split_once(':').unwrap();
        let source = SHARED.iter().copied().chain([main]).find(|part| part.file == file).unwrap();
        let line = line.rsplit_once("@binding(").map_or(line, |(_, rest)| &rest[rest.find(' ').unwrap() + 1..]);
        assert_eq!(source.text.lines().nth(number.parse::<usize>().unwrap() - 1), Some(line), "{origin}");
    }
    assert!(text.contains("fn pixel_index") && !text.contains("struct Pixel"));
}

/// The linker does not report a misspelt marker.
#[test]
fn markers_stand_in_shared_files_and_are_whole() {
    for (line, file) in SHARED.iter().flat_map(|part| part.text.lines().map(|line| (line, part.file))) {
        let marker = line.split_once("//!").map(|(_, marker)| marker.trim());
        let condition = |marker: &'static str| Condition::all_of(marker.strip_prefix("if ")?);
        let is_whole = |marker| marker == "end" || condition(marker).is_some() || marker.starts_with("use ");
        assert!(marker.is_none_or(is_whole), "{file}: {line}");
    }
}
