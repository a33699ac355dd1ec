//! One sitting: a preset, the changes over it, and what is wrong with it.

use std::sync::Arc;

use super::desk::{Desk, Opened};
use super::history::History;
use super::problem::Problem;
use super::save::{self, SaveError};
use super::setting::{Changes, Setting, written};
use super::skin::{Made, SkinNews, SkinRequest};
use crate::base::MapKind;
use crate::preset::builtin;

/// The state of the window that files and maps depend on.
pub(super) struct Session {
    opened: Arc<Opened>,
    history: History<Changes>,
    /// Of the file's text as it is now: the skin is of the last good one.
    text_problems: Vec<Problem>,
    /// Of the preset with its changes.
    skin_problems: Vec<Problem>,
    number: u64,
    /// Whether what was asked last is not what is wanted now.
    stale: bool,
    made: Option<Made>,
}

impl Session {
    /// Begin with a preset and changes over it.
    pub(super) fn new(opened: Opened, changes: Changes) -> Self {
        Self {
            opened: Arc::new(opened),
            history: History::new(changes),
            text_problems: Vec::new(),
            skin_problems: Vec::new(),
            number: 0,
            stale: true,
            made: None,
        }
    }

    /// The preset.
    pub(super) fn opened(&self) -> &Arc<Opened> {
        &self.opened
    }

    /// What is laid over it.
    pub(super) fn changes(&self) -> &Changes {
        self.history.now()
    }

    /// The last good maps.
    pub(super) fn made(&self) -> Option<&Made> {
        self.made.as_ref()
    }

    /// Whether maps are being made.
    pub(super) fn is_busy(&self) -> bool {
        let last = self.made.as_ref().is_some_and(|m| m.number == self.number && m.last);
        self.stale || !(last || self.skin_problems.iter().any(|p| p.error))
    }

    /// What is wrong.
    pub(super) fn problems(&self) -> impl Iterator<Item = &Problem> {
        self.text_problems.iter().chain(&self.skin_problems)
    }

    /// The value at a path: changed, or the preset's own.
    pub(super) fn value(&self, path: &str) -> Option<Setting> {
        self.changes().get(path).cloned().or_else(|| self.own(path))
    }

    /// The preset's own value at a path.
    pub(super) fn own(&self, path: &str) -> Option<Setting> {
        written(&self.opened.document, path).and_then(Setting::of_item)
    }

    /// Whether the window changed the value at a path.
    pub(super) fn is_changed(&self, path: &str) -> bool {
        self.changes().contains_key(path)
    }

    /// Change a value. What the preset itself says, or `default` where it says nothing, is no change.
    pub(super) fn set(&mut self, path: &str, setting: Setting, default: Option<&Setting>) {
        let mut changes = self.changes().clone();
        let own = self.own(path);
        if own.as_ref().or(default).is_some_and(|own| own.means(&setting)) {
            changes.remove(path);
        } else {
            changes.insert(path.to_owned(), setting);
        }
        self.move_to(changes, path);
    }

    /// Take the change of a value back.
    pub(super) fn reset(&mut self, path: &str) {
        let mut changes = self.changes().clone();
        changes.remove(path);
        self.settle();
        self.move_to(changes, path);
        self.settle();
    }

    /// Take all changes back; that, too, can be undone.
    pub(super) fn reset_all(&mut self) {
        self.settle();
        self.move_to(Changes::new(), "");
        self.settle();
    }

    fn move_to(&mut self, changes: Changes, what: &str) {
        if changes != *self.changes() {
            self.history.set(changes, what);
            self.stale = true;
        }
    }

    /// A drag ended: the next change is a step of its own.
    pub(super) fn settle(&mut self) {
        self.history.settle();
    }

    /// Whether a step can be taken back, and forward again.
    pub(super) fn can_undo_redo(&self) -> [bool; 2] {
        [self.history.can_undo(), self.history.can_redo()]
    }

    /// Take a step back.
    pub(super) fn undo(&mut self) {
        self.stale |= self.history.undo();
    }

    /// Take a step forward again.
    pub(super) fn redo(&mut self) {
        self.stale |= self.history.redo();
    }

    /// The individual.
    pub(super) fn seed(&self) -> u64 {
        let seed = self.value("seed").and_then(|s| s.number().map(|_| s));
        if let Some(Setting::Whole(seed)) = seed { seed.max(0) as u64 } else { 0 }
    }

    /// Another individual.
    pub(super) fn set_seed(&mut self, seed: u64) {
        // Presets hold whole numbers of 63 bits.
        let seed = i64::try_from(seed).unwrap_or(i64::MAX);
        self.set("seed", Setting::Whole(seed), Some(&Setting::Whole(0)));
    }

    /// What is to be made now, unless that is made or being made.
    pub(super) fn request(&mut self, maps: &[MapKind], sizes: &[usize]) -> Option<SkinRequest> {
        if !std::mem::take(&mut self.stale) {
            return None;
        }
        self.number += 1;
        Some(SkinRequest {
            number: self.number,
            opened: self.opened.clone(),
            changes: self.changes().clone(),
            maps: maps.into(),
            sizes: sizes.into(),
        })
    }

    /// Other maps or sizes are wanted.
    pub(super) fn ask_again(&mut self) {
        self.stale = true;
    }

    /// Take what came of a request; what is not of the newest one is dropped. On an error the last good maps stay.
    pub(super) fn take(&mut self, news: SkinNews) {
        match news {
            SkinNews::Made(made) if made.number == self.number => {
                self.skin_problems = made.warnings.clone();
                self.made = Some(made);
            }
            SkinNews::Failed { number, problems } if number == self.number => self.skin_problems = problems,
            _ => {}
        }
    }

    /// The preset's files were read anew. What is not sound is told, and the last good text stays.
    pub(super) fn reloaded(&mut self, opened: Result<Opened, Vec<Problem>>) {
        match opened {
            Ok(opened) => {
                self.text_problems.clear();
                self.opened = Arc::new(opened);
                self.stale = true;
            }
            Err(problems) => self.text_problems = problems,
        }
    }

    /// Go on with another preset, or with one that the changes were saved to.
    pub(super) fn open(&mut self, opened: Opened) {
        let number = self.number;
        *self = Self { number, made: self.made.take(), ..Self::new(opened, Changes::new()) };
    }

    /// Whether the preset comes with the command: then it is saved as one that includes it.
    pub(super) fn is_builtin(&self) -> bool {
        self.opened.document.sources.sources().first().is_some_and(|s| builtin::is_builtin(&s.name))
    }

    /// Where the preset is saved unless told otherwise.
    pub(super) fn save_path(&self) -> String {
        let name = &self.opened.document.name;
        if !self.is_builtin() {
            return name.clone();
        }
        let stem = name.rsplit('/').next().unwrap_or(name).trim_end_matches(".toml");
        format!("my_{stem}.toml")
    }

    /// The text to save: the file's own with only the changed values changed, or a new one over a built-in preset.
    ///
    /// # Errors
    /// If a change has no place in the text.
    pub(super) fn save_text(&self) -> Result<String, SaveError> {
        let document = &self.opened.document;
        let own = document.sources.sources().first();
        let text = match own {
            Some(source) if !self.is_builtin() => source.text.to_string(),
            _ => save::over(document.name.rsplit('/').next().unwrap_or(&document.name)),
        };
        save::patched(&text, document, self.changes())
    }

    /// Save the changes, and go on with what was saved.
    ///
    /// # Errors
    /// A sentence.
    pub(super) fn save(&mut self, desk: &dyn Desk, path: &str) -> Result<(), String> {
        if path.trim().is_empty() || !path.ends_with(".toml") {
            return Err("a preset's name ends in .toml".into());
        }
        let text = self.save_text().map_err(|e| e.to_string())?;
        desk.save(path, &text)?;
        let first = |problems: Vec<Problem>| problems.first().map_or(String::new(), |p| p.message.clone());
        let opened = desk.open(path).map_err(first)?;
        self.open(opened);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::testing::Table;

    fn session() -> Session {
        Session::new(Table.open("python_regius").expect("a built-in preset"), Changes::new())
    }

    #[test]
    fn a_value_set_back_by_hand_is_no_change() {
        let mut session = session();
        session.set("scales.rows", Setting::Whole(31), None);
        assert!(session.is_changed("scales.rows"));
        assert_eq!(session.value("scales.rows"), Some(Setting::Whole(31)));
        session.set("scales.rows", Setting::Whole(57), None);
        assert!(!session.is_changed("scales.rows"));
        // And so is the default of a key that the preset does not write.
        session.set("scales.keel", Setting::Number(0.0), Some(&Setting::Number(0.0)));
        assert!(session.changes().is_empty());
    }

    #[test]
    fn each_change_is_asked_for_once() {
        let mut session = session();
        assert_eq!(session.request(&[], &[64]).map(|r| r.number), Some(1));
        assert!(session.request(&[], &[64]).is_none());
        session.set("scales.rows", Setting::Whole(31), None);
        let request = session.request(&[], &[64]).expect("a change");
        assert_eq!((request.number, request.changes.len()), (2, 1));
        session.set("scales.rows", Setting::Whole(31), None);
        assert!(session.request(&[], &[64]).is_none());
        session.undo();
        assert_eq!(session.request(&[], &[64]).map(|r| r.changes.len()), Some(0));
        session.undo();
        assert!(session.request(&[], &[64]).is_none(), "there is nothing to undo");
    }

    #[test]
    fn old_news_is_dropped_and_errors_leave_the_last_good_skin() {
        let mut session = session();
        session.request(&[], &[64]);
        let set = crate::viewer::skin::graph(session.opened(), session.changes(), &Table)
            .and_then(|(g, _)| crate::viewer::skin::evaluate(&g, &[], 16, None, Default::default()))
            .expect("sound")
            .expect("nobody cancelled");
        let made = |number| {
            let set = Arc::new(set.clone());
            SkinNews::Made(Made { number, set, milliseconds: 1.0, last: true, warnings: Vec::new() })
        };
        session.take(made(7));
        assert!(session.made().is_none() && session.is_busy());
        session.take(made(1));
        assert!(session.made().is_some() && !session.is_busy());
        session.set("scales.rows", Setting::Whole(0), None);
        session.request(&[], &[64]);
        assert!(session.is_busy());
        session.take(SkinNews::Failed { number: 2, problems: vec![Problem::plain("no rows", "")] });
        assert_eq!(session.problems().count(), 1);
        assert!(session.made().is_some() && !session.is_busy());
        session.undo();
        session.request(&[], &[64]);
        session.take(made(3));
        assert_eq!(session.problems().count(), 0);
    }

    #[test]
    fn a_broken_file_is_told_and_the_good_text_stays_until_it_is_mended() {
        let mut session = session();
        session.request(&[], &[64]);
        session.reloaded(Err(vec![Problem::plain("a value is missing", "")]));
        assert_eq!(session.problems().count(), 1);
        assert!(session.request(&[], &[64]).is_none());
        assert_eq!(session.value("scales.rows"), Some(Setting::Whole(57)));
        session.reloaded(Table.open("crotalus_atrox"));
        assert_eq!(session.problems().count(), 0);
        assert!(session.request(&[], &[64]).is_some());
        assert_ne!(session.value("scales.rows"), Some(Setting::Whole(57)));
    }

    #[test]
    fn a_built_in_preset_is_saved_as_one_that_stands_on_it() {
        let mut session = session();
        session.set_seed(9);
        session.set("scales.rows", Setting::Whole(31), None);
        assert_eq!(session.save_path(), "my_python_regius.toml");
        let text = session.save_text().expect("both have a place");
        assert_eq!(text, "include = \"python_regius.toml\"\nseed = 9\n\n[scales]\nrows = 31\n");
        assert_eq!(session.save(&Table, "x.txt"), Err("a preset's name ends in .toml".into()));
        assert_eq!(session.save(&Table, "x.toml"), Err("x.toml is no file".into()));
        assert_eq!(session.changes().len(), 2, "what was not saved is still there");
    }

    #[test]
    fn seeds_are_what_presets_can_hold() {
        let mut session = session();
        session.set_seed(u64::MAX);
        assert_eq!(session.seed(), i64::MAX as u64);
        session.set_seed(0);
        assert_eq!(session.seed(), 0);
    }
}
