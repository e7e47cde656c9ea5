//! Which files a document may make a program read and write.

use crate::{CheckedGraph, Diagnostic, FrameContext, Item, NodeId, OutputSpec, Severity, Takes, quoted_path};
use std::path::{Component, Path, PathBuf};

/// Which files a document may make a program read and write: folders with all beneath them, and single files.
///
/// A document may come from anywhere, and every path in it is a wish of whoever wrote it. Engines ask before a stage
/// prepares, and outputs before they are named, so a node cannot forget to.
///
/// ```
/// use std::path::Path;
/// use trochoid_graph::Access;
///
/// let access = Access::beneath(Path::new("shots/a"));
/// assert!(access.check(Path::new("shots/a/paint/skin.png")).is_ok());
/// assert!(access.check(Path::new("shots/a/../b/skin.png")).is_err());
/// assert!(access.allowing(Path::new("shots/b")).check(Path::new("shots/a/../b/skin.png")).is_ok());
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Access {
    /// `None` is everything.
    roots: Option<Vec<Root>>,
    overwrites: bool,
}

/// A folder with all beneath it, or a file, and what may be done there.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Root {
    /// Resolved.
    path: PathBuf,
    rights: &'static [Right],
}

/// What a document may make a program do with a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Right {
    /// Read it.
    Read,
    /// Write it.
    Write,
}

impl Right {
    const BOTH: &[Self] = &[Self::Read, Self::Write];

    fn alone(self) -> &'static [Self] {
        match self {
            Self::Read => &[Self::Read],
            Self::Write => &[Self::Write],
        }
    }
}

impl Root {
    fn new(path: &Path, rights: &'static [Right]) -> Self {
        Self { path: resolved(path), rights }
    }
}

/// A path that leads where a document may not reach.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outside {
    /// Where it leads: absolute, with links followed.
    pub leads_to: PathBuf,
    /// What is allowed.
    pub allowed: Vec<PathBuf>,
}

impl Outside {
    /// The folder that has to be allowed.
    pub fn folder(&self) -> &Path {
        self.leads_to.parent().unwrap_or(&self.leads_to)
    }

    fn expected(&self) -> String {
        let allowed: Vec<String> = self.allowed.iter().map(|root| root.display().to_string()).collect();
        format!("one beneath what the document may reach: {}", allowed.join(", "))
    }

    fn remedy(&self) -> String {
        remedy([self])
    }
}

fn remedy<'o>(paths: impl IntoIterator<Item = &'o Outside, IntoIter: ExactSizeIterator>) -> String {
    let paths = paths.into_iter();
    let what = if paths.len() == 1 { "it" } else { "them" };
    format!("if you trust the document with {what}: {}", allow_options(paths))
}

/// The faults of files that a document may not reach, each with the remedy for all.
pub fn refusals(refused: &[Refused]) -> Vec<Diagnostic> {
    let remedy = remedy(refused.iter().map(|refused| &refused.outside));
    refused.iter().map(|refused| Diagnostic { remedy: remedy.clone(), ..refused.diagnostic() }).collect()
}

/// The options of the command line that allow all of some paths, as a shell takes them: a folder each, and none that lies
/// beneath another.
pub fn allow_options<'o>(paths: impl IntoIterator<Item = &'o Outside>) -> String {
    let folders: Vec<&Path> = paths.into_iter().map(Outside::folder).collect();
    let mut named: Vec<&Path> = Vec::new();
    for folder in &folders {
        let is_beneath = |other: &&Path| folder.starts_with(other) && folder != other;
        if !folders.iter().any(is_beneath) && !named.contains(folder) {
            named.push(folder);
        }
    }
    named.iter().map(|folder| format!("--allow {}", quoted_path(folder))).collect::<Vec<_>>().join(" ")
}

impl std::fmt::Display for Outside {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "found the file {}; expected {}; {}", self.leads_to.display(), self.expected(), self.remedy())
    }
}

impl Access {
    /// What lies beneath one folder: for servers, to which a document is a stranger's.
    pub fn beneath(folder: &Path) -> Self {
        Self { roots: Some(vec![Root::new(folder, Right::BOTH)]), overwrites: false }
    }

    /// What lies beneath a document's folder and, where that lies beneath the current folder, beneath that one. What a
    /// graph may reach unless it is told otherwise.
    ///
    /// The root of the file system is the current folder of services: it counts as none.
    pub fn usual(folder: &Path) -> Self {
        let own = Root::new(folder, Right::BOTH);
        let current = Root::new(Path::new("."), Right::BOTH);
        let holds = own.path.starts_with(&current.path) && current.path.parent().is_some() && own != current;
        Self { roots: Some([own].into_iter().chain(holds.then_some(current)).collect()), overwrites: false }
    }

    /// Every file: for documents that are trusted as programs are.
    pub fn everything() -> Self {
        Self { roots: None, overwrites: false }
    }

    /// The same, and a file, or a folder with all beneath it.
    #[must_use]
    pub fn allowing(self, path: &Path) -> Self {
        self.with(path, Right::BOTH)
    }

    /// The same, and a file, or a folder with all beneath it, for one thing alone.
    #[must_use]
    pub fn granting(self, path: &Path, right: Right) -> Self {
        self.with(path, right.alone())
    }

    fn with(mut self, path: &Path, rights: &'static [Right]) -> Self {
        if let Some(roots) = &mut self.roots {
            roots.push(Root::new(path, rights));
        }
        self
    }

    /// The same, where files may be replaced that Trochoid did not write.
    #[must_use]
    pub fn overwriting(self, overwrites: bool) -> Self {
        Self { overwrites, ..self }
    }

    /// Whether files may be replaced that Trochoid did not write.
    pub fn overwrites(&self) -> bool {
        self.overwrites
    }

    /// Whether a path may be read; it need not exist.
    ///
    /// # Errors
    /// It leads elsewhere.
    pub fn check(&self, path: &Path) -> Result<(), Outside> {
        self.check_for(path, Right::Read)
    }

    /// Whether this may be done with a path; it need not exist.
    ///
    /// # Errors
    /// It leads elsewhere.
    pub fn check_for(&self, path: &Path, right: Right) -> Result<(), Outside> {
        let Some(roots) = &self.roots else { return Ok(()) };
        let leads_to = resolved(path);
        let roots: Vec<&PathBuf> =
            roots.iter().filter(|root| root.rights.contains(&right)).map(|root| &root.path).collect();
        if roots.iter().any(|root| leads_to.starts_with(root)) {
            return Ok(());
        }
        Err(Outside { leads_to, allowed: roots.into_iter().cloned().collect() })
    }
}

/// Links followed one after another before a path counts as leading nowhere.
const MOST_LINKS: usize = 40;

/// Where a path leads: absolute, links followed as far as there are any, `..` applied to what stands before it. What does
/// not exist yet counts as folders that will be made.
pub fn resolved(path: &Path) -> PathBuf {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    if let Ok(whole) = path.canonicalize() {
        return whole;
    }
    // What is still to be made in a folder that exists, which is most of what is asked: two looks are enough.
    if let (Some(folder), Some(name)) = (path.parent(), path.file_name()) {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        if let Ok(folder) = folder.canonicalize()
            && folder.join(name).symlink_metadata().is_err()
        {
            return folder.join(name);
        }
    }
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.into());
    let mut links = 0;
    follow(PathBuf::new(), &absolute, &mut links)
}

/// Walks a path from a folder that is resolved.
fn follow(mut at: PathBuf, path: &Path, links: &mut usize) -> PathBuf {
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                at.pop();
            }
            Component::Prefix(_) | Component::RootDir => at.push(part),
            Component::Normal(name) => {
                let next = at.join(name);
                at = match next.canonicalize() {
                    Ok(whole) => whole,
                    // A link to what does not exist: a file would be made there.
                    Err(_) => match next.read_link() {
                        Ok(target) if *links < MOST_LINKS => {
                            *links += 1;
                            follow(at, &target, links)
                        }
                        _ => next,
                    },
                };
            }
        }
    }
    at
}

/// A file that a document names and may not reach.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// The document's name.
    pub document: String,
    /// The node that would read it; `None` for the file of an output.
    pub node: Option<String>,
    /// The knob that names it, or the output; `None` where a file names it that the node reads.
    pub item: Option<String>,
    /// Line and column in the document.
    pub place: [usize; 2],
    /// The path as it is written, with the frame filled in.
    pub path: PathBuf,
    /// Where it leads, and what is allowed.
    pub outside: Outside,
}

impl std::error::Error for Refused {}

impl Refused {
    /// The fault, with the place in the document and the remedy.
    pub fn diagnostic(&self) -> Diagnostic {
        let [line, column] = self.place;
        Diagnostic {
            severity: Severity::Error,
            file: self.document.clone(),
            line,
            column,
            node: self.node.clone(),
            port: self.item.clone(),
            found: self.found(),
            expected: self.outside.expected(),
            remedy: self.outside.remedy(),
        }
    }

    /// What the document asks to do with it.
    pub fn right(&self) -> Right {
        if self.node.is_some() { Right::Read } else { Right::Write }
    }

    fn found(&self) -> String {
        let (path, leads_to) = (self.path.display(), self.outside.leads_to.display());
        let same = self.path == self.outside.leads_to;
        if same { format!("the file {path}") } else { format!("the file {path}, which is {leads_to}") }
    }
}

/// What was found and expected, and what to do: as a node says it.
impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "found {}; expected {}; {}", self.found(), self.outside.expected(), self.outside.remedy())
    }
}

impl CheckedGraph {
    /// Which files the document may reach.
    pub fn access(&self) -> &Access {
        &self.access
    }

    /// The same graph with another rule for the files that the document may reach: by default [`Access::usual`] of its
    /// folder. What assignments beside the document name (`--set`) is allowed whatever the rule.
    #[must_use]
    pub fn with_access(mut self, access: Access) -> Self {
        self.access = access;
        self
    }

    /// The first file that a node would read at a frame and may not: engines ask before the node prepares.
    pub fn refused(&self, id: NodeId, context: &FrameContext) -> Option<Refused> {
        let node = self.node(id);
        let settled = self.settle(id, context.frame);
        let mut trusted = Vec::new();
        let mut named = Vec::new();
        for item in node.ty.declaration().items {
            let Item::Knob(knob) = item else { continue };
            if !matches!(knob.takes, Takes::Path) || !settled.is_set(knob.name) {
                continue;
            }
            let path = context.path(settled.text(knob.name));
            if node.is_assigned(knob.name) {
                trusted.push(path);
            } else {
                named.push((Some(knob.name), path));
            }
        }
        named.extend(self.files_of(id, context).into_iter().map(|path| (None, path)));
        let mut open = named.into_iter().filter(|(_, path)| !trusted.contains(path));
        open.find_map(|(item, path)| {
            let outside = self.access.check(&path).err()?;
            let place = item.map_or(node.place, |item| node.place_of(item));
            let (document, item) = (self.name.clone(), item.map(String::from));
            Some(Refused { document, node: Some(node.name.clone()), item, place, path, outside })
        })
    }

    /// What is wrong with writing an output where the document itself wants it.
    ///
    /// # Errors
    /// It leads where the document may not reach.
    pub fn check_written(&self, output: &OutputSpec, path: &Path) -> Result<(), Box<Refused>> {
        self.access.check_for(path, Right::Write).map_err(|outside| {
            Box::new(Refused {
                document: self.name.clone(),
                node: None,
                item: Some(format!("output \"{}\", file", output.name)),
                place: output.place,
                path: path.into(),
                outside,
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn folder() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().canonicalize().expect("there");
        (folder, path)
    }

    #[test]
    fn options_allow_each_folder_once_as_a_shell_takes_them() {
        let outside = |path: &str| Outside { leads_to: path.into(), allowed: Vec::new() };
        let paths = ["/a b/x.png", "/c/d/y.png", "/c/z.png", "/c/z2.png", "/it's/#1/x"].map(outside);
        assert_eq!(allow_options(&paths), r##"--allow '/a b' --allow /c --allow "/it's/#1""##);
        assert!(paths[0].to_string().ends_with("--allow '/a b'"));
    }

    #[test]
    fn dots_and_what_does_not_exist_yet_are_resolved() {
        let (_held, root) = folder();
        fs::create_dir_all(root.join("a/b")).expect("made");
        let access = Access::beneath(&root.join("a"));
        for inside in ["a/x.png", "a/b/../x.png", "a/new/deep/x.png", "a/new/../x.png", "a/./b", "a", "b/../a/x"] {
            assert!(access.check(&root.join(inside)).is_ok(), "{inside}");
        }
        for outside in ["x.png", "a/../x.png", "a/new/../../x.png", "ab/x.png", "a/b/../../../x", "../x", "."] {
            let refused = access.check(&root.join(outside)).expect_err(outside);
            assert!(refused.leads_to.is_absolute() && !refused.leads_to.starts_with(root.join("a")), "{refused:?}");
        }
        assert!(access.check(Path::new("/")).is_err());
        assert!(Access::everything().check(Path::new("/etc/passwd")).is_ok());
    }

    #[test]
    fn a_folder_that_is_not_there_yet_and_a_file_are_allowed() {
        let (_held, root) = folder();
        let access =
            Access::beneath(&root.join("a")).allowing(&root.join("new/folder")).allowing(&root.join("one.png"));
        assert!(access.check(&root.join("new/folder/x.png")).is_ok());
        assert!(access.check(&root.join("one.png")).is_ok());
        for outside in ["new/x.png", "one.png.exr", "two.png"] {
            assert!(access.check(&root.join(outside)).is_err(), "{outside}");
        }
    }

    #[test]
    fn what_may_be_read_may_not_be_written_and_the_other_way() {
        let (_held, root) = folder();
        let access = Access::beneath(&root.join("a"))
            .granting(&root.join("in"), Right::Read)
            .granting(&root.join("out"), Right::Write)
            .allowing(&root.join("both"));
        for (path, reads, writes) in
            [("a/x", true, true), ("in/x", true, false), ("out/x", false, true), ("both/x", true, true)]
        {
            let may = [Right::Read, Right::Write].map(|right| access.check_for(&root.join(path), right).is_ok());
            assert_eq!(may, [reads, writes], "{path}");
        }
        let refused = access.check_for(&root.join("in/x"), Right::Write).expect_err("read only");
        assert_eq!(refused.allowed, [root.join("a"), root.join("out"), root.join("both")]);
    }

    #[cfg(unix)]
    #[test]
    fn links_count_by_where_they_lead() {
        use std::os::unix::fs::symlink;
        let (_held, root) = folder();
        for name in ["a", "elsewhere", "a/b"] {
            fs::create_dir_all(root.join(name)).expect("made");
        }
        fs::write(root.join("elsewhere/secret"), "").expect("written");
        symlink(root.join("elsewhere"), root.join("a/out")).expect("a link");
        symlink("../elsewhere/secret", root.join("a/file")).expect("a link");
        symlink("../elsewhere/not_yet", root.join("a/dangling")).expect("a link");
        symlink("b", root.join("a/within")).expect("a link");
        symlink("loop", root.join("a/loop")).expect("a link");
        symlink(root.join("a"), root.join("alias")).expect("a link");
        let access = Access::beneath(&root.join("a"));
        for outside in
            ["a/out/x", "a/out/secret", "a/file", "a/dangling", "a/out/new/x", "a/within/../../x", "a/out/.."]
        {
            assert!(access.check(&root.join(outside)).is_err(), "{outside}");
        }
        for inside in ["a/within/x", "a/within/../x", "alias/x", "a/loop"] {
            assert!(access.check(&root.join(inside)).is_ok(), "{inside}");
        }
        // A rule may itself be stated through a link.
        assert!(Access::beneath(&root.join("alias")).check(&root.join("a/x")).is_ok());
    }
}
