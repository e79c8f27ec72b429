//! `--scenario`, `--date`: which scenario of a project a command looks at, and what day.

use relievo_engine::Engine;
use relievo_engine::project::{Date, Edit, parse_date};

use super::Failure;

/// Which scenario a command looks at.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct Scenario {
    /// The scenario to look at, by its name or id; `base` is the project without any. Default: the one
    /// that the project shows.
    #[arg(long, value_name = "NAME")]
    scenario: Option<String>,
    /// The day that series of layers are shown at. Default: the one that the project shows.
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = day)]
    date: Option<Date>,
}

fn day(text: &str) -> Result<Date, String> {
    parse_date(text).ok_or_else(|| "expected a day as 2015-09-26".to_owned())
}

impl Scenario {
    /// Has the engine show the scenario that was asked for.
    pub(crate) fn show(&self, engine: &mut Engine) -> Result<(), Failure> {
        if self.date.is_some() {
            let edit = Edit::ShowDate { date: self.date };
            engine.apply(edit).map_err(Failure::input)?;
        }
        let Some(name) = &self.scenario else {
            return Ok(());
        };
        let project = engine.project();
        let id = match project.scenario_called(name) {
            Some(scenario) => Some(scenario.id.clone()),
            None if name == "base" => None,
            None => {
                let names = project.scenarios.iter().map(|s| format!("{:?}", s.name));
                let names: Vec<String> = names.chain(["base".to_owned()]).collect();
                return Err(Failure::Input(format!(
                    "--scenario: expected one of {}, found {name:?}",
                    names.join(", ")
                )));
            }
        };
        engine
            .apply(Edit::ShowScenario { id })
            .map_err(Failure::input)
    }
}
