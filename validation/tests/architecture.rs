//! The top-level modules of the core depend on each other in one direction only, and no crate has circular
//! dependencies between its files.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A top-level module uses only modules listed before it, here and in ARCHITECTURE.md.
const MODULES: [&str; 13] = [
    "error",
    "numeric",
    "model",
    "inference",
    "answer",
    "motion",
    "paper",
    "signal",
    "record",
    "ringdown",
    "resonance",
    "levels",
    "series",
];

/// The crates, relative to the root of the repository.
const CRATES: [&str; 10] = [
    "crates/slipfit",
    "crates/slipfit-io",
    "crates/slipfit-batch",
    "crates/slipfit-report",
    "crates/slipfit-cli",
    "crates/slipfit-py",
    "crates/slipfit-wasm",
    "validation",
    "validation/real-data",
    "xtask",
];

type Module = Vec<String>;

/// The modules of a crate with what each uses, without tests.
struct Modules {
    /// Source text without comments and tests.
    texts: BTreeMap<Module, String>,
    /// Names that a module re-exports.
    reexports: BTreeMap<Module, Vec<(String, Module)>>,
}

impl Modules {
    fn of(folder: &str) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder).join("src");
        let mut texts = BTreeMap::new();
        for file in files(&root) {
            let module: Module = file
                .strip_prefix(&root)
                .unwrap()
                .with_extension("")
                .iter()
                .map(|part| part.to_string_lossy().into_owned())
                .filter(|part| !["mod", "lib", "main"].contains(&part.as_str()))
                .collect();
            let text: &mut String = texts.entry(module).or_default();
            text.push_str(&code(&std::fs::read_to_string(&file).unwrap()));
        }
        // Modules compiled for tests only.
        let tests = |(module, text): (&Module, &String)| -> Vec<Module> {
            let names = text.split("#[cfg(test)]").skip(1).filter_map(|after| {
                let name = after.trim_start().strip_prefix("pub(crate) ").unwrap_or(after.trim_start());
                name.strip_prefix("mod ")?.split_once(';').map(|(name, _)| name.to_owned())
            });
            names.map(|name| module.iter().cloned().chain([name]).collect()).collect()
        };
        let tests: Vec<Module> = texts.iter().flat_map(tests).collect();
        texts.retain(|module, _| {
            !module.contains(&"tests".to_owned()) && !tests.iter().any(|test| module.starts_with(test))
        });
        let mut all = Self { texts, reexports: BTreeMap::new() };
        let reexports = all.texts.iter().map(|(module, text)| (module.clone(), all.uses(module, text, true)));
        all.reexports = reexports.collect();
        all
    }

    /// Paths that a module names by `use` or in full: last name and absolute path.
    fn uses(&self, module: &Module, text: &str, public: bool) -> Vec<(String, Module)> {
        let mut found = Vec::new();
        let mut elsewhere = String::new();
        let mut rest = text;
        while let Some(at) = rest.find("use ") {
            let before = rest[..at].lines().last().unwrap_or_default().trim();
            let end = rest[at..].find(';').map_or(rest.len(), |length| at + length + 1);
            let declared = before.is_empty() || before.starts_with("pub");
            elsewhere.push_str(if declared { &rest[..at] } else { &rest[..end] });
            if declared && (!public || before.starts_with("pub")) {
                for path in expanded(rest[at + 4..end].trim_end_matches(';')) {
                    found.extend(self.absolute(module, &path));
                }
            }
            rest = &rest[end..];
        }
        elsewhere.push_str(rest);
        if !public {
            for path in elsewhere.split(|c: char| !c.is_alphanumeric() && !"_:".contains(c)) {
                if path.contains("::") {
                    found.extend(self.absolute(module, path));
                }
            }
        }
        found
    }

    /// A path from the root of the crate, and the name it introduces; `None` for other crates.
    fn absolute(&self, module: &Module, path: &str) -> Option<(String, Module)> {
        let mut parts: Vec<&str> = path.split("::").filter(|part| !part.is_empty()).collect();
        let mut name = (*parts.last()?).to_owned();
        if let Some((renamed, alias)) = path.split_once(" as ") {
            parts = renamed.split("::").collect();
            name = alias.trim().to_owned();
        }
        let mut base = module.clone();
        match parts.first()?.trim() {
            "crate" => base.clear(),
            "self" => {}
            "super" => {
                base.pop();
            }
            first => {
                base.push(first.to_owned());
                if !self.texts.contains_key(&base) {
                    return None;
                }
            }
        }
        for part in &parts[1..] {
            if *part == "super" {
                base.pop();
            } else {
                base.push(part.trim().to_owned());
            }
        }
        Some((name, base))
    }

    /// The module that defines the item of a path, following re-exports.
    fn definition(&self, path: &Module) -> Module {
        let mut path = path.clone();
        for _ in 0..8 {
            let length = (0..=path.len()).rev().find(|n| self.texts.contains_key(&path[..*n])).unwrap_or(0);
            let (module, inside) = path.split_at(length);
            let Some(name) = inside.first() else { return module.to_vec() };
            let offered = self.reexports.get(module).and_then(|list| list.iter().find(|(n, _)| n == name));
            match offered {
                Some((_, elsewhere)) if *elsewhere != path => path = elsewhere.clone(),
                _ => return module.to_vec(),
            }
        }
        path
    }

    /// The modules that each module depends on.
    fn needs(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        let needs = |(module, text): (&Module, &String)| {
            // A module that re-exports names of its submodules does not depend on them.
            let offered: Vec<&Module> = self.reexports[module].iter().map(|(_, path)| path).collect();
            let used = self.uses(module, text, false).into_iter().map(|(_, path)| path);
            let used = used.filter(|path| !offered.contains(&path)).map(|path| self.definition(&path));
            (module.clone(), used.filter(|used| used != module && !used.is_empty()).collect())
        };
        self.texts.iter().map(needs).collect()
    }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            all.push(path);
        }
    }
    all
}

/// Source text up to the tests at the end, without comments.
fn code(text: &str) -> String {
    let end = text.find("\nmod tests").unwrap_or(text.len());
    let lines = text[..end].lines().map(|line| line.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// `a::{b, c::{d, e}}` as `a::b`, `a::c::d`, `a::c::e`.
fn expanded(path: &str) -> Vec<String> {
    let path = path.split_whitespace().collect::<Vec<_>>().join(" ");
    let Some((head, rest)) = path.split_once('{') else { return vec![path.trim().to_owned()] };
    let inner = rest.rsplit_once('}').map_or(rest, |(inner, _)| inner);
    let (mut depth, mut start, mut all) = (0, 0, Vec::new());
    for (at, c) in inner.char_indices().chain([(inner.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                let one = inner[start..at].trim();
                start = at + 1;
                let whole = |rest: String| format!("{}{rest}", head.trim()).replace("::self", "");
                all.extend(expanded(one).into_iter().filter(|rest| !rest.is_empty()).map(whole));
            }
            _ => {}
        }
    }
    all
}

#[test]
fn a_module_uses_only_modules_before_it() {
    let core = Modules::of("crates/slipfit");
    let place =
        |name: &str| MODULES.iter().position(|m| *m == name).unwrap_or_else(|| panic!("module {name}"));
    let mut backwards = Vec::new();
    for (module, needs) in core.needs() {
        for need in needs {
            if let [top, ..] = &module[..]
                && place(&need[0]) > place(top)
            {
                backwards.push(format!("{} uses {}", module.join("/"), need.join("/")));
            }
        }
    }
    assert!(backwards.is_empty(), "{}", backwards.join("\n"));
}

#[test]
fn modules_are_listed_in_the_same_order_in_the_architecture() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../ARCHITECTURE.md");
    let text = std::fs::read_to_string(page).unwrap();
    let (_, table) = text.split_once("## Modules of the core").unwrap();
    let rows =
        table.lines().take_while(|line| !line.starts_with("## ")).filter_map(|line| line.strip_prefix("| `"));
    let modules: Vec<&str> = rows.filter_map(|row| row.split_once('`')).map(|(name, _)| name).collect();
    assert_eq!(modules, MODULES);
}

/// Modules that depend on themselves through other modules.
fn circular(needs: &BTreeMap<Module, BTreeSet<Module>>) -> Vec<String> {
    let reach = |from: &Module| {
        let (mut reached, mut next) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(module) = next.pop() {
            for need in needs.get(&module).into_iter().flatten() {
                if reached.insert(need.clone()) {
                    next.push(need.clone());
                }
            }
        }
        reached
    };
    needs.keys().filter(|m| reach(m).contains(*m)).map(|m| m.join("/")).collect()
}

#[test]
fn no_file_depends_on_itself() {
    let found: Vec<String> = CRATES
        .into_iter()
        .map(|folder| (folder, circular(&Modules::of(folder).needs())))
        .filter(|(_, circular)| !circular.is_empty())
        .map(|(folder, circular)| format!("{folder}: {}", circular.join(", ")))
        .collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn grouped_uses_are_taken_apart() {
    assert_eq!(
        expanded("crate::a::{self, b, c::{D, E}}"),
        ["crate::a", "crate::a::b", "crate::a::c::D", "crate::a::c::E"]
    );
    assert_eq!(expanded("super::x"), ["super::x"]);
}
