//! The factor on heights, and the greatest that the planet bears under the drawn ground.

use relievo_planet::Planet;
use relievo_project::{Edit, EditError, Fault};

use super::Engine;
use crate::message::{Message, Severity};

impl Engine {
    /// The factor that heights are drawn with: the project's, or the greatest that keeps the lowest
    /// drawn ground at a tenth of the radius. A message says where it is not the project's.
    pub fn exaggeration(&self) -> f64 {
        let settings = &self.project.planet;
        let limit = self.greatest_exaggeration(&settings.body.figure());
        settings.vertical_exaggeration.min(limit)
    }

    /// R + e · h ≥ 0.1 R, h the lowest drawn height.
    fn greatest_exaggeration(&self, planet: &Planet) -> f64 {
        planet.greatest_exaggeration(self.planned_on.0.0.min_m)
    }

    /// Refuses a factor beyond the greatest.
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "no other edit changes planet or factor"
    )]
    pub(super) fn check_exaggeration(&self, edit: &Edit) -> Result<(), EditError> {
        let settings = &self.project.planet;
        let (planet, wanted) = match edit {
            Edit::SetExaggeration {
                vertical_exaggeration,
            } => (settings.body.figure(), *vertical_exaggeration),
            Edit::SetPlanet { planet } => (planet.body.figure(), planet.vertical_exaggeration),
            Edit::Batch { edits, .. } => {
                return edits.iter().try_for_each(|e| self.check_exaggeration(e));
            }
            _ => return Ok(()),
        };
        let limit = self.greatest_exaggeration(&planet);
        if wanted > limit {
            return Err(EditError::Invalid(Fault {
                pointer: "/vertical_exaggeration".to_owned(),
                expected: format!("at most {}", named_limit(limit, self.planned_on.0.0.min_m)),
                found: wanted.to_string(),
            }));
        }
        Ok(())
    }

    /// Says so while less is drawn than the project asks for.
    pub(super) fn tell_exaggeration(&mut self) {
        let wanted = self.project.planet.vertical_exaggeration;
        let drawn = self.exaggeration();
        let message = (drawn < wanted).then(|| Message {
            severity: Severity::Warning,
            layer: None,
            element: None,
            text: format!(
                "vertical exaggeration: expected at most {}, found {wanted}: drawn with the greatest",
                named_limit(drawn, self.planned_on.0.0.min_m)
            ),
        });
        self.messages.replace_drawn(message);
    }
}

fn named_limit(limit: f64, lowest_m: f64) -> String {
    format!(
        "{limit:.6} so that the lowest ground, {lowest_m:.1} m, stays a tenth of the radius from the planet's centre"
    )
}
