//! From files of earlier versions to the current one.

use crate::Extra;

/// Turns the members of a file of one version into those of the next.
type Migration = fn(Extra) -> Extra;

/// `MIGRATIONS[n − 1]` leads from version n to n + 1; as many as versions before the current one.
const MIGRATIONS: [Migration; super::v1::VERSION as usize - 1] = [];

/// Brings the members of a file of `version` (1 to the current one) to the current version, its
/// number included.
pub(crate) fn to_current(version: u32, members: Extra) -> Extra {
    run(&MIGRATIONS, version, members)
}

fn run(migrations: &[Migration], version: u32, members: Extra) -> Extra {
    let steps = migrations.iter().skip((version as usize).saturating_sub(1));
    let mut members = steps.fold(members, |members, migrate| migrate(members));
    if let Some(number) = members.get_mut("version") {
        *number = (migrations.len() + 1).into();
    }
    members
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_file_runs_through_every_migration_after_its_version() {
        fn log(mut members: Extra, step: u32) -> Extra {
            let before = members
                .get("log")
                .and_then(|v| v.as_str())
                .unwrap_or("")
                .to_owned();
            members.insert("log".into(), format!("{before}{step}").into());
            members
        }
        let chain: [Migration; 3] = [|m| log(m, 1), |m| log(m, 2), |m| log(m, 3)];
        for (version, expected) in [(1, json!("123")), (2, json!("23")), (3, json!("3"))] {
            let mut members = Extra::new();
            members.insert("version".into(), version.into());
            let done = run(&chain, version, members);
            assert_eq!(done["log"], expected);
            assert_eq!(done["version"], 4);
        }
    }
}
