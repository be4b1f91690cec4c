use super::*;
use std::os::unix::fs::symlink;

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_link_is_followed_and_kept() {
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

/// File systems without unnamed temporary files, or on which these cannot be linked.
#[test]
fn named_temporary_files_are_renamed_into_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a");
    for content in ["named", "again"] {
        let mut unfinished = stale::new(&path).expect("a file");
        unfinished.write_all(content.as_bytes()).expect("written");
        assert!(names(folder.path())[0].ends_with(".part"));
        Unfinished::Named(unfinished).take_name(&path).expect("a name");
        assert_eq!(
            (fs::read_to_string(&path).expect("there"), names(folder.path())),
            (content.into(), vec!["a".into()])
        );
    }
    let mut other = tempfile::tempfile().expect("a file");
    other.write_all(b"copied").expect("written");
    copied(&other, &path).expect("copied").persist(&path).expect("a name");
    assert_eq!((fs::read(&path).expect("there"), names(folder.path())), (b"copied".to_vec(), vec!["a".to_owned()]));
}

#[test]
fn only_stale_files_are_removed() {
    let folder = tempfile::tempdir().expect("a folder");
    let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
    // The file of a killed process is not locked.
    let (file, dead) = stale::new(&a).expect("a file").keep().expect("kept");
    drop(file);
    let (file, other) = stale::new(&b).expect("a file").keep().expect("kept");
    drop(file);
    let mut alive = stale::new(&a).expect("a file");
    alive.write_all(b"alive").expect("written");
    assert!(
        alive.path() == dead && other.exists(),
        "its own name is free again, the name of another file is not touched"
    );
    let second = stale::new(&a).expect("a file");
    assert!(second.path() != alive.path() && alive.path().exists(), "a file that is being written is not touched");
    drop(second);
    alive.persist(&a).expect("a name");
    assert_eq!((fs::read(&a).expect("there"), names(folder.path()).len()), (b"alive".to_vec(), 2));
    write_atomically(&b, |out| out.write_all(b"b")).expect("written");
    assert!(other.exists(), "an anonymous file does not search for stale names");
    write_atomically(&b, |out| out.write_all(b"b")).expect("written");
    assert_eq!(names(folder.path()), ["a", "b"], "a file that replaces another one does");
}

/// The frames of a film that are rendered at once write one legend.
#[test]
fn threads_that_write_one_file_do_not_remove_each_others() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a");
    let write = |content: &[u8]| (0..200).try_for_each(|_| write_atomically(&path, |out| out.write_all(content)));
    std::thread::scope(|scope| {
        let writers = [b"1", b"2", b"3", b"4"].map(|content| scope.spawn(move || write(content)));
        writers.into_iter().for_each(|writer| writer.join().expect("a thread").expect("written"));
    });
    assert_eq!((fs::read(&path).expect("there").len(), names(folder.path())), (1, vec!["a".to_owned()]));
}

#[test]
#[cfg(target_os = "linux")]
fn an_unfinished_file_has_no_name() {
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
