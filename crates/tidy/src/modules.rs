//! The module tree of a crate, and which file defines what a path names.

use crate::source::{is_ident, is_punct, tokens};
use anyhow::{Context, Result};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

/// Names separated by `::`.
type NamePath = Vec<String>;

/// A module: a file, or a block within one.
#[derive(Default)]
pub(crate) struct Module {
    pub(crate) file: PathBuf,
    pub(crate) parent: Option<usize>,
    children: BTreeMap<String, usize>,
    /// What `use` brings in: the name it gets here, and the path.
    imports: Vec<(String, NamePath)>,
    /// The paths before `::*`.
    globs: Vec<NamePath>,
    /// Names of items that are defined here.
    items: BTreeSet<String>,
    /// Every path that is named here, those of `use` included.
    pub(crate) paths: Vec<NamePath>,
}

/// The modules of one crate; the first is the root.
pub(crate) struct Modules(pub(crate) Vec<Module>);

/// Keywords that a name follows which paths can refer to.
const ITEMS: [&str; 8] = ["struct", "enum", "union", "trait", "fn", "type", "const", "static"];
/// Re-exports of re-exports are followed this often, so that an import of itself ends.
const MOST_HOPS: usize = 16;

impl Modules {
    /// Reads the crate whose root is `root`, from a table of files.
    pub(crate) fn read(root: &Path, files: &BTreeMap<&Path, &str>) -> Result<Self> {
        let mut modules = Self(Vec::new());
        modules.file(root, None, root.parent().unwrap_or(Path::new("")), files)?;
        Ok(modules)
    }

    /// Reads a file; `folder` is where the files of its modules are.
    fn file(
        &mut self,
        path: &Path,
        parent: Option<usize>,
        folder: &Path,
        files: &BTreeMap<&Path, &str>,
    ) -> Result<usize> {
        let text = files.get(path).with_context(|| format!("no file {}", path.display()))?;
        let stream = tokens(text).with_context(|| path.display().to_string())?;
        self.module(path, parent, folder, stream, files)
    }

    fn module(
        &mut self,
        path: &Path,
        parent: Option<usize>,
        folder: &Path,
        stream: TokenStream,
        files: &BTreeMap<&Path, &str>,
    ) -> Result<usize> {
        let index = self.0.len();
        self.0.push(Module { file: path.to_owned(), parent, ..Module::default() });
        let tokens: Vec<TokenTree> = stream.into_iter().collect();
        let mut rest = Vec::new();
        let mut at = 0;
        while at < tokens.len() {
            match &tokens[at..] {
                [keyword, TokenTree::Ident(name), body, ..] if is_ident(keyword, "mod") => {
                    let name = name.to_string();
                    let folder_of_child = folder.join(&name);
                    let child = if let TokenTree::Group(body) = body {
                        self.module(path, Some(index), &folder_of_child, body.stream(), files)?
                    } else if let Some(named) = path_attribute(&tokens[..at]) {
                        let file = normal(&path.parent().unwrap_or(Path::new("")).join(named));
                        let inside = file.parent().unwrap_or(Path::new("")).to_owned();
                        self.file(&file, Some(index), &inside, files)?
                    } else {
                        let flat = folder.join(name.clone() + ".rs");
                        let nested = folder_of_child.join("mod.rs");
                        let file = if files.contains_key(&*flat) { flat } else { nested };
                        self.file(&file, Some(index), &folder_of_child, files)?
                    };
                    self.0[index].children.insert(name, child);
                    at += 3;
                }
                _ => {
                    rest.push(tokens[at].clone());
                    at += 1;
                }
            }
        }
        self.0[index].collect(&rest);
        Ok(index)
    }

    /// The module that defines what `path`, written in `scope`, names; none if another crate does.
    pub(crate) fn resolve(&self, scope: usize, path: &[String]) -> Option<usize> {
        self.follow(scope, path, MOST_HOPS).map(|(module, _)| module)
    }

    /// As [`Self::resolve`]; says also whether the path names the module itself.
    fn follow(&self, scope: usize, path: &[String], hops: usize) -> Option<(usize, bool)> {
        let (first, rest) = path.split_first()?;
        let (mut at, mut is_module) = match first.as_str() {
            "crate" => (0, true),
            "self" => (scope, true),
            "super" => (self.0[scope].parent?, true),
            name => self.look_up(scope, name, hops)?,
        };
        for name in rest {
            if !is_module {
                break;
            }
            (at, is_module) = match name.as_str() {
                "self" => (at, true),
                "super" => (self.0[at].parent?, true),
                // An item that a macro made is not in the list, but cannot be anywhere else.
                name => self.look_up(at, name, hops).unwrap_or((at, false)),
            };
        }
        Some((at, is_module))
    }

    fn look_up(&self, scope: usize, name: &str, hops: usize) -> Option<(usize, bool)> {
        let hops = hops.checked_sub(1)?;
        let module = &self.0[scope];
        if let Some(&child) = module.children.get(name) {
            return Some((child, true));
        }
        if let Some((_, path)) = module.imports.iter().find(|(alias, _)| alias == name) {
            return self.follow(scope, path, hops);
        }
        if module.items.contains(name) {
            return Some((scope, false));
        }
        module.globs.iter().find_map(|path| match self.follow(scope, path, hops)? {
            (target, true) if target != scope => self.look_up(target, name, hops),
            _ => None,
        })
    }
}

impl Module {
    /// Takes the imports, items and paths out of tokens.
    fn collect(&mut self, tokens: &[TokenTree]) {
        let mut at = 0;
        while at < tokens.len() {
            let rest = &tokens[at..];
            at += match rest {
                // Not the `use<'a>` of a return type.
                [keyword, next, ..] if is_ident(keyword, "use") && !is_punct(next, '<') => {
                    let end = rest.iter().position(|token| is_punct(token, ';'));
                    let end = end.unwrap_or(rest.len());
                    self.tree(&rest[1..end], &[]);
                    end
                }
                [TokenTree::Ident(keyword), TokenTree::Ident(name), ..]
                    if ITEMS.iter().any(|item| keyword == item) =>
                {
                    self.items.insert(name.to_string());
                    // The name of a `const fn` is still to come.
                    if name == "fn" { 1 } else { 2 }
                }
                [TokenTree::Ident(_), ..] => {
                    let (path, length) = inline_path(rest);
                    if path.len() > 1 {
                        self.paths.push(path);
                    }
                    length
                }
                [TokenTree::Group(group), ..] => {
                    self.collect(&group.stream().into_iter().collect::<Vec<_>>());
                    1
                }
                _ => 1,
            };
        }
    }

    /// Adds a tree of `use`: `tokens` after the names `before`.
    fn tree(&mut self, tokens: &[TokenTree], before: &[String]) {
        let mut path = before.to_vec();
        let mut alias = None;
        for (at, token) in tokens.iter().enumerate() {
            match token {
                TokenTree::Ident(word) if word == "as" => {
                    alias = tokens.get(at + 1).map(ToString::to_string);
                    break;
                }
                TokenTree::Ident(name) => path.push(name.to_string()),
                TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                    let inside: Vec<TokenTree> = group.stream().into_iter().collect();
                    for branch in inside.split(|token| is_punct(token, ',')) {
                        if !branch.is_empty() {
                            self.tree(branch, &path);
                        }
                    }
                    return;
                }
                token if is_punct(token, '*') => {
                    self.paths.push(path.clone());
                    self.globs.push(path);
                    return;
                }
                _ => {}
            }
        }
        if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        let Some(alias) = alias.or_else(|| path.last().cloned()) else { return };
        self.imports.push((alias, path.clone()));
        self.paths.push(path);
    }
}

/// The path without `folder/..`.
fn normal(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut path, part| {
        match part {
            Component::ParentDir => drop(path.pop()),
            part => path.push(part),
        }
        path
    })
}

/// The names at the start of tokens that `::` joins, and how many tokens they are.
fn inline_path(tokens: &[TokenTree]) -> (NamePath, usize) {
    let mut path = vec![tokens[0].to_string()];
    let mut length = 1;
    while let [first, second, TokenTree::Ident(name), ..] = &tokens[length..]
        && is_punct(first, ':')
        && is_punct(second, ':')
    {
        path.push(name.to_string());
        length += 3;
    }
    (path, length)
}

/// The file that a `#[path = "…"]` right before tokens end names.
fn path_attribute(tokens: &[TokenTree]) -> Option<String> {
    let of_item = tokens.iter().rev().take_while(|token| !is_punct(token, ';'));
    of_item.take(6).find_map(|token| {
        let TokenTree::Group(group) = token else { return None };
        let text = group.stream().to_string();
        let value = text.strip_prefix("path")?.trim_start().strip_prefix('=')?;
        Some(value.trim().trim_matches('"').to_owned())
    })
}
