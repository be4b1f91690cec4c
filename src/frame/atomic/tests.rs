use super::stale::{named, remove};
use super::*;
use std::os::unix::fs::symlink;

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_link_is_followed_and_stays() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("far")).expect("made");
    symlink("far/target", path("link")).expect("linked");
    symlink("link", path("chain")).expect("linked");
    for content in ["first, where nothing is", "second"] {
        check_writable(&path("chain")).expect("writable");
        write_atomically(&path("chain"), |out| out.write_all(content.as_bytes())).expect("written");
        assert_eq!(fs::read_to_string(path("far/target")).expect("there"), content);
    }
    assert!(path("link").is_symlink() && path("chain").is_symlink());
    assert_eq!(
        (names(folder.path()), names(&path("far"))),
        (vec!["chain".into(), "far".into(), "link".into()], vec!["target".into()])
    );
    symlink("round", path("round")).expect("linked");
    for error in [check_writable(&path("round")), write_atomically(&path("round"), |_| Ok(()))] {
        assert!(error.expect_err("no end").to_string().contains("link"));
    }
}

/// Where there are no nameless files, and where they get no name.
#[test]
fn named_files_are_put_in_place_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a");
    let mut unfinished = named(folder.path()).expect("a file");
    unfinished.write_all(b"named").expect("written");
    assert_eq!(names(folder.path()).len(), 1);
    Unfinished::Named(unfinished).take_name(&path).expect("a name");
    assert_eq!((fs::read(&path).expect("there"), names(folder.path()).len()), (b"named".to_vec(), 1));
    let mut other = tempfile::tempfile().expect("a file");
    other.write_all(b"copied").expect("written");
    copied(other, folder.path()).expect("copied").persist(&path).expect("a name");
    assert_eq!((fs::read(&path).expect("there"), names(folder.path()).len()), (b"copied".to_vec(), 1));
}

#[test]
fn only_what_is_certainly_stale_is_removed() {
    let folder = tempfile::tempdir().expect("a folder");
    let prefix = ".halfline-ours-";
    let make = |prefix: &str| builder(prefix).tempfile_in(folder.path()).expect("a file");
    // What a process leaves that is killed: nobody holds its lock.
    let (_, dead) = make(prefix).keep().expect("kept");
    let alive = make(prefix);
    rustix::fs::flock(alive.as_file(), rustix::fs::FlockOperation::NonBlockingLockExclusive).expect("a lock");
    let (_, other) = make(".halfline-other-").keep().expect("kept");
    fs::write(folder.path().join(".halfline-ours-x.png"), "").expect("written");
    fs::write(folder.path().join("a.part"), "").expect("written");
    remove(folder.path(), prefix);
    assert!(!dead.exists() && alive.path().exists() && other.exists());
    assert_eq!(names(folder.path()).len(), 4);
    drop(alive);
    assert_eq!(names(folder.path()).len(), 3, "a file that is given up is removed at once");
}

#[test]
#[cfg(target_os = "linux")]
fn a_file_that_is_being_written_has_no_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a");
    write_atomically(&path, |out| {
        out.write_all(&[1; 1 << 20])?;
        assert_eq!(names(folder.path()), [""; 0]);
        Ok(())
    })
    .expect("written");
    assert_eq!(names(folder.path()), ["a"]);
}
