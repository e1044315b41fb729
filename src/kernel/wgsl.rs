//! Linker of WGSL. A kernel's text consists of its own file and the definitions of `shaders/shared/` that the file
//! uses.
//!
//! Each file begins with a list of the shared files that it uses (`//! use camera, lane`). A test compares these lists
//! with the actual uses, and detects cycles among shared files. Every top-level name (`fn`, `struct`, `const`,
//! `override`, `var`, `alias`) belongs to the file that defines it. The linker adds each definition that a kernel's
//! file uses, directly or indirectly, once. The order of WGSL definitions does not matter. A name that the kernel's own
//! file defines (a binding such as `view`) takes precedence, even where shared definitions use it.
//!
//! A definition uses all its words except comments, words after a dot, and its own names (locals, parameters, members).
//! Therefore a definition must not give one of its own names the name of a shared definition that it uses. The linker
//! would omit the shared definition, and a compiler would report it as missing.
//!
//! If a name has several definitions, each of them is in a section of its file with a condition:
//!
//! ```wgsl
//! //! if sky is constant
//! fn sky(direction: F3) -> F3 { … }
//! //! if sky is gradient or map
//! …
//! //! end
//! ```
//!
//! A section may depend on several choices: `//! if sky is map and lights is none`. It ends at the next section, at
//! `//! end`, or with its file. `src/kernel/variant.rs` makes all choices.
//!
//! A resource is a `var` without an address space, or in `uniform` or `storage`. WGSL files omit its group and binding.
//! The linker numbers the resources of each text and returns them by name.

use std::{collections::HashMap, sync::LazyLock};

use crate::{
    gpu::{
        ACCELERATION, TEXELS, sampled_float_type, sampled_layers_type, sampled_type, storage_type, texture_type,
        uniform_type,
    },
    kernel::Resource,
};

/// A WGSL file: its name below `shaders/` and its text.
#[derive(Clone, Copy)]
pub(crate) struct Part {
    pub(crate) file: &'static str,
    pub(crate) text: &'static str,
}

macro_rules! part {
    ($file:expr) => {
        $crate::kernel::wgsl::Part {
            file: $file,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $file)),
        }
    };
}
pub(crate) use part;

/// A choice: its name and its value.
pub(crate) type Choice = (&'static str, &'static str);

macro_rules! shared {
    ($($name:literal,)*) => {
        &[$(part!(concat!("shared/", $name, ".wgsl"))),*]
    };
}

/// All files of `shaders/shared/`.
pub(crate) const SHARED: &[Part] = shared![
    "aims",
    "angles",
    "around",
    "bits",
    "bounced",
    "boxes",
    "busy",
    "bvh",
    "camera",
    "counters",
    "cutouts",
    "dice",
    "display",
    "double_float",
    "earlier_light",
    "earlier_quad",
    "ellipsoid",
    "emitters",
    "facets",
    "fetch",
    "first_vertex",
    "frame",
    "history",
    "in_steps",
    "jitter",
    "kept_samples",
    "lane",
    "lens",
    "light",
    "light_parts",
    "lights",
    "linear",
    "lists",
    "looks",
    "marks",
    "materials",
    "noisy",
    "objects",
    "octahedral",
    "own_hits",
    "path_steps",
    "paths",
    "pixels",
    "planes",
    "primitive",
    "primitives",
    "projection",
    "projectors",
    "proposed",
    "ray_list",
    "ray_queries",
    "rays",
    "recall",
    "reflectance",
    "scattering",
    "search",
    "sent_rays",
    "shade",
    "shadow_buffer",
    "shadow_canvas",
    "shadows",
    "sky",
    "sky_light",
    "sobol",
    "soft",
    "source_samples",
    "sphere",
    "stack",
    "surfaces",
    "t_buffer",
    "table",
    "textures",
    "tiles",
    "triangle",
    "verify",
    "view",
    "visibility",
    "wanted",
];

/// The values of a choice for which a section applies. If a section has several conditions, all must hold.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Condition {
    pub(crate) choice: &'static str,
    pub(crate) values: Vec<&'static str>,
}

impl Condition {
    /// Parses one condition, such as `sky is gradient or map`.
    fn of(text: &'static str) -> Option<Self> {
        let (choice, values) = text.split_once(" is ")?;
        Some(Self { choice: choice.trim(), values: values.split(" or ").map(str::trim).collect() })
    }

    /// Parses several conditions, such as `planes is some and sky is gradient or map`.
    fn all_of(text: &'static str) -> Option<Vec<Self>> {
        text.split(" and ").map(Self::of).collect()
    }

    fn holds(&self, choices: &[Choice]) -> bool {
        choices.iter().any(|(choice, value)| *choice == self.choice && self.values.contains(value))
    }
}

/// A top-level definition of a file.
pub(crate) struct Definition {
    pub(crate) name: &'static str,
    pub(crate) file: &'static str,
    /// Number of its first line, counted from 1.
    pub(crate) line: usize,
    pub(crate) when: Vec<Condition>,
    /// Binding type, if the definition is a resource.
    binding: Option<wgpu::BindingType>,
    /// Offset of its text in the file.
    at: usize,
    text: &'static str,
    /// Words that may be names of other definitions.
    uses: Vec<&'static str>,
}

/// The linked text of a kernel.
#[derive(Clone, Debug)]
pub(crate) struct Linked {
    pub(crate) text: String,
    /// Resources that the text binds in group 0, from binding 0 on.
    pub(crate) bindings: Vec<Binding>,
}

/// A resource that a linked text binds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Binding {
    pub(crate) resource: Resource,
    pub(crate) ty: wgpu::BindingType,
}

impl Linked {
    /// Adds a definition at the end of the text, with its binding if it is a resource.
    fn add(&mut self, definition: &Definition) {
        if let Some(ty) = definition.binding {
            self.text += &format!("@group(0) @binding({}) ", self.bindings.len());
            self.bindings.push(Binding { resource: Resource::named(definition.name), ty });
        }
        self.text += definition.text;
    }
}

/// The shared definitions, and their indices by name.
struct Library {
    definitions: Vec<Definition>,
    by_name: HashMap<&'static str, Vec<usize>>,
}

static LIBRARY: LazyLock<Library> = LazyLock::new(|| {
    let definitions: Vec<_> = SHARED.iter().flat_map(|part| definitions(*part)).collect();
    let mut by_name = HashMap::<_, Vec<_>>::new();
    for (index, definition) in definitions.iter().enumerate() {
        by_name.entry(definition.name).or_default().push(index);
    }
    Library { definitions, by_name }
});

/// Links a kernel. The text has the shared definitions that the kernel uses under these choices, then the kernel's own
/// file. A comment with file and line (`// shared/lane.wgsl:7`) precedes each shared definition and the kernel's file.
/// With it, compiler messages can be traced to the source.
pub(crate) fn linked(main: Part, choices: &[Choice]) -> Linked {
    let own = definitions(main);
    let mut taken = vec![false; LIBRARY.definitions.len()];
    let mut wanted: Vec<&str> = own.iter().flat_map(|definition| &definition.uses).copied().collect();
    while let Some(name) = wanted.pop() {
        if own.iter().any(|definition| definition.name == name) {
            continue;
        }
        for &index in LIBRARY.by_name.get(name).into_iter().flatten() {
            let Definition { when, uses, .. } = &LIBRARY.definitions[index];
            if !taken[index] && when.iter().all(|condition| condition.holds(choices)) {
                taken[index] = true;
                wanted.extend(uses);
            }
        }
    }
    let mut linked = Linked { text: String::new(), bindings: Vec::new() };
    for (definition, _) in LIBRARY.definitions.iter().zip(taken).filter(|(_, taken)| *taken) {
        linked.text += &format!("// {}:{}\n", definition.file, definition.line);
        linked.add(definition);
        linked.text += "\n";
    }
    linked.text += &format!("// {}:1\n", main.file);
    let mut copied = 0;
    for definition in &own {
        linked.text += &main.text[copied..definition.at];
        linked.add(definition);
        copied = definition.at + definition.text.len();
    }
    linked.text += &main.text[copied..];
    linked
}

/// Returns the file below `shaders/`, and the line in it, from which a line of a kernel's text was copied. Lines count
/// from 1.
#[cfg(test)]
pub(crate) fn origin(text: &str, line: usize) -> Option<String> {
    let above = text.lines().take(line - 1).enumerate();
    let marks = above.filter_map(|(index, above)| {
        let (file, first) = above.strip_prefix("// ")?.rsplit_once(".wgsl:")?;
        Some((file, first.parse::<usize>().ok()? + line - 2 - index))
    });
    marks.last().map(|(file, line)| format!("{file}.wgsl:{line}"))
}

/// Returns the names of the shared files that a file uses under any choices, and the names of the shared files that it
/// lists.
#[cfg(test)]
pub(crate) fn uses_of(part: Part) -> [std::collections::BTreeSet<&'static str>; 2] {
    let own = definitions(part);
    let used = own.iter().flat_map(|definition| &definition.uses);
    let others = used.filter(|name| own.iter().all(|definition| definition.name != **name));
    let found = others.filter_map(|name| LIBRARY.by_name.get(name)).flatten();
    let stem = |file: &'static str| file.trim_start_matches("shared/").trim_end_matches(".wgsl");
    let found = found.map(|&index| stem(LIBRARY.definitions[index].file)).collect();
    let listed = part.text.lines().filter_map(|line| line.strip_prefix("//! use "));
    [found, listed.flat_map(|names| names.split(", ")).collect()]
}

/// Returns all shared definitions.
#[cfg(test)]
pub(crate) fn shared() -> &'static [Definition] {
    &LIBRARY.definitions
}

/// Returns the top-level definitions of a file, each with the conditions of its section.
pub(crate) fn definitions(part: Part) -> Vec<Definition> {
    let mut found = Vec::new();
    let mut when = Vec::new();
    let mut words = Vec::new();
    let mut begin = 0;
    let mut depth = 0;
    for (at, word) in words_of(part.text) {
        if let Some(marker) = word.strip_prefix("//!") {
            when = marker.trim().strip_prefix("if ").and_then(Condition::all_of).unwrap_or_default();
        }
        if word.starts_with("//") {
            continue;
        }
        if words.is_empty() {
            begin = at;
        }
        words.push(word);
        match word {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => depth -= 1,
            _ => {}
        }
        if depth == 0 && matches!(word, ";" | "}") {
            found.extend(name_of(&words).map(|name| Definition {
                name,
                file: part.file,
                line: 1 + part.text[..begin].matches('\n').count(),
                when: when.clone(),
                binding: binding_of(&words),
                at: begin,
                text: &part.text[begin..at + 1],
                uses: used_by(&words),
            }));
            words.clear();
        }
    }
    found
}

/// Returns the words, marks and comments (`//` only) of a WGSL text, each with its offset.
fn words_of(text: &'static str) -> impl Iterator<Item = (usize, &'static str)> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut at = 0;
    std::iter::from_fn(move || {
        at += text[at..].find(|c: char| !c.is_whitespace())?;
        let rest = &text[at..];
        let end = match rest {
            _ if rest.starts_with("//") => rest.find('\n'),
            _ if rest.starts_with(is_word) => rest.find(|c| !is_word(c)),
            _ => rest.char_indices().nth(1).map(|(end, _)| end),
        };
        let word = &rest[..end.unwrap_or(rest.len())];
        at += word.len();
        Some((at - word.len(), word))
    })
}

/// Returns the name that a definition defines: the word before its type, value, parameters or members.
fn name_of(words: &[&'static str]) -> Option<&'static str> {
    let keywords = ["alias", "const", "fn", "override", "struct", "var"];
    let keyword = words.iter().position(|word| keywords.contains(word))?;
    let end = words[keyword..].iter().position(|word| matches!(*word, ":" | "=" | "(" | "{"))?;
    Some(words[keyword + end - 1])
}

/// Returns the type of a definition's resource, or `None` for other definitions.
fn binding_of(words: &[&'static str]) -> Option<wgpu::BindingType> {
    use wgpu::{StorageTextureAccess as Access, TextureFormat as Format};

    match words {
        ["var", "<", "uniform", ">", ..] => Some(uniform_type()),
        ["var", "<", "storage", ",", "read", ">", ..] => Some(storage_type(true)),
        ["var", "<", "storage", ",", "read_write", ">", ..] => Some(storage_type(false)),
        ["var", _, ":", "acceleration_structure", ..] => Some(ACCELERATION),
        ["var", _, ":", "texture_2d", "<", "f32", ..] => Some(sampled_float_type()),
        ["var", _, ":", "texture_2d", "<", "u32", ..] => Some(sampled_type()),
        ["var", _, ":", "texture_2d_array", "<", "u32", ..] => Some(sampled_layers_type()),
        ["var", _, ":", "texture_storage_2d", "<", format, ",", access, ..] => {
            let format = match *format {
                "rgba32uint" => TEXELS,
                "rgba8unorm" => Format::Rgba8Unorm,
                "r32float" => Format::R32Float,
                "rgba16float" => Format::Rgba16Float,
                other => unreachable!("no kernel has a texture of {other}"),
            };
            let access = match *access {
                "read" => Access::ReadOnly,
                "write" => Access::WriteOnly,
                other => unreachable!("no kernel has a texture with access {other}"),
            };
            Some(texture_type(format, access))
        }
        _ => None,
    }
}

/// Returns the words that may name other definitions. These exclude words after a dot and the definition's own names:
/// locals, parameters and members.
fn used_by(words: &[&'static str]) -> Vec<&'static str> {
    let mut in_case = false;
    let mut own = Vec::new();
    let mut used = Vec::new();
    for (index, &word) in words.iter().enumerate() {
        let before = if index > 0 { words[index - 1] } else { "" };
        let after = words.get(index + 1).copied().unwrap_or_default();
        in_case = word == "case" || (in_case && !matches!(word, ":" | "{"));
        if !word.starts_with(|c: char| c.is_alphabetic() || c == '_') || before == "." {
            continue;
        }
        match before {
            "let" | "var" | "const" => own.push(word),
            _ if after == ":" && !in_case => own.push(word),
            _ => used.push(word),
        }
    }
    used.sort_unstable();
    used.dedup();
    used.retain(|word| !own.contains(word));
    used
}

#[cfg(test)]
mod tests;
