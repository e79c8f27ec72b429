use relievo_raster::{Bands, Block, SampleType};

use super::*;

const MS: Duration = Duration::from_millis(1);

fn id(n: u8) -> ContentId {
    ContentId([n; 32])
}

fn tile(n: u8) -> Tile {
    let mut block = Block::new(Bands::Height, 256, 256);
    block.samples_mut()[0] = f32::from(n) + 1.0;
    Tile::from_block(&block, SampleType::Height)
}

fn files(folder: &Folder) -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = folder
        .measure()
        .unwrap()
        .into_iter()
        .map(|e| e.path)
        .collect();
    all.sort();
    all
}

fn used(folder: &Folder) -> u64 {
    folder.measure().unwrap().iter().map(|e| e.bytes).sum()
}

#[test]
fn what_was_kept_is_found_by_the_next_program() {
    let dir = tempfile::tempdir().unwrap();
    let first = Folder::new(dir.path(), 1 << 30);
    assert!(first.may_have(id(1)), "nobody has looked yet");
    assert!(first.load(id(1)).is_none());
    assert!(first.save(id(1), &tile(1), 5 * MS));
    let second = Folder::new(dir.path(), 1 << 30);
    second.list();
    assert!(second.may_have(id(1)) && !second.may_have(id(2)));
    let loaded = second.load(id(1)).unwrap();
    assert_eq!(
        (loaded.tile.bytes(), loaded.cost),
        (tile(1).bytes(), 5 * MS)
    );
    // What another program adds later is not known here, which costs no more than making it.
    first.save(id(2), &tile(2), MS);
    assert!(!second.may_have(id(2)) && second.load(id(2)).is_some());
}

#[test]
fn damaged_truncated_and_misplaced_entries_are_removed_and_strangers_are_left_alone() {
    let dir = tempfile::tempdir().unwrap();
    let folder = Folder::new(dir.path(), 1 << 30);
    for n in 0..4 {
        folder.save(id(n), &tile(n), MS);
    }
    let path = |n| folder.path(&folder.name(id(n)));
    let mut bytes = fs::read(path(0)).unwrap();
    bytes[5000] ^= 1;
    fs::write(path(0), bytes).unwrap();
    File::options()
        .write(true)
        .open(path(1))
        .unwrap()
        .set_len(100)
        .unwrap();
    fs::copy(path(3), path(2)).unwrap();
    let stranger = path(3).with_file_name("notes.txt");
    fs::write(&stranger, "mine").unwrap();
    for n in 0..3 {
        assert!(folder.load(id(n)).is_none());
        assert!(!path(n).exists());
    }
    assert!(folder.load(id(3)).is_some());
    assert!(stranger.exists());
}

#[test]
fn the_bound_holds_and_what_is_old_and_cheap_goes_first() {
    let dir = tempfile::tempdir().unwrap();
    let bound = 2_700_000; // ten tiles
    let folder = Folder::new(dir.path(), bound);
    folder.save(id(200), &tile(0), 4000 * MS);
    for n in 0..60 {
        assert!(folder.save(id(n), &tile(n), MS));
        assert!(used(&folder) <= bound, "{} after {n}", used(&folder));
    }
    assert!(folder.load(id(200)).is_some(), "dear, so it outlives sixty");
    assert!(folder.load(id(59)).is_some() && folder.load(id(0)).is_none());
    // A smaller bound is met at the next tile.
    let smaller = Folder::new(dir.path(), bound / 3);
    assert!(smaller.save(id(100), &tile(100), MS));
    assert!(used(&smaller) <= bound / 3);
    assert!(!Folder::new(dir.path(), 0).save(id(101), &tile(1), MS));
    assert!(!Folder::new(dir.path(), 1000).save(id(101), &tile(1), MS));
}

#[test]
fn a_use_renews_the_claim() {
    let dir = tempfile::tempdir().unwrap();
    let folder = Folder::new(dir.path(), 1 << 30);
    folder.save(id(1), &tile(1), MS);
    let path = folder.path(&folder.name(id(1)));
    let old = SystemTime::now() - Duration::from_hours(100);
    let file = File::options().write(true).open(&path).unwrap();
    file.set_times(FileTimes::new().set_modified(old)).unwrap();
    folder.load(id(1)).unwrap();
    assert!(path.metadata().unwrap().modified().unwrap() > old + Duration::from_hours(99));
}

#[test]
fn programs_that_share_a_folder_do_not_disturb_each_other() {
    let dir = tempfile::tempdir().unwrap();
    let bound = 4_000_000;
    let work = || {
        let folder = Folder::new(dir.path(), bound);
        folder.list();
        for round in 0..40 {
            let n = round % 20;
            if let Some(loaded) = folder.load(id(n)) {
                assert_eq!(loaded.tile.bytes(), tile(n).bytes());
            } else {
                assert!(folder.save(id(n), &tile(n), MS));
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(work);
        }
    });
    let folder = Folder::new(dir.path(), bound);
    assert!(used(&folder) <= bound + 3 * bound / 16);
    assert!(files(&folder).iter().all(|f| name_of(f).is_some()));
}

#[test]
fn what_an_early_end_left_unfinished_is_removed() {
    let dir = tempfile::tempdir().unwrap();
    let folder = Folder::new(dir.path(), 1 << 30);
    folder.save(id(1), &tile(1), MS);
    let shard = folder.path(&folder.name(id(1)));
    let (old, new) = (
        shard.with_file_name(".new-1-1"),
        shard.with_file_name(".new-1-2"),
    );
    for path in [&old, &new] {
        fs::write(path, "half").unwrap();
    }
    let long_ago = SystemTime::now() - Duration::from_hours(2);
    let file = File::options().write(true).open(&old).unwrap();
    file.set_times(FileTimes::new().set_modified(long_ago))
        .unwrap();
    assert_eq!(files(&folder).len(), 1);
    assert!(!old.exists() && new.exists());
}

#[test]
fn a_folder_that_cannot_be_written_turns_storing_off() {
    let dir = tempfile::tempdir().unwrap();
    let in_the_way = dir.path().join("file");
    fs::write(&in_the_way, "not a folder").unwrap();
    let folder = Folder::new(&in_the_way, 1 << 30);
    folder.list();
    assert!(folder.load(id(1)).is_none());
    assert!(!folder.save(id(1), &tile(1), MS));
    assert!(folder.full.load(Ordering::Relaxed));
    assert!(!folder.save(id(1), &tile(1), MS));
}
