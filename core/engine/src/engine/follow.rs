//! A second view: an engine that shows what another one edits.

use relievo_project::Project;

use super::Engine;

impl Engine {
    /// Shows this project, which another engine edits, from now on: what both have in common is not
    /// made again. The history is not touched and means nothing here.
    pub fn follow(&mut self, project: Project) {
        if self.project == project {
            return;
        }
        self.project = project;
        self.sources.require(&self.project, &self.folder);
        (self.stale, self.dirty) = (true, true);
    }
}
