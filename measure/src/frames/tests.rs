use super::*;
use crate::Values;
use halfline::error::Error;
use halfline_files::write::buffers::NamedBuffer;

fn array(values: &[f32], shape: &[usize]) -> Array {
    Array::new("made", shape.to_vec(), Values::F32(values.to_vec())).expect("whole")
}

fn frames(name: &str, buffers: &[(Option<&str>, f32)]) -> FrameFile {
    let buffer =
        |(name, x): &(Option<&str>, f32)| NamedBuffer { name: name.map(str::to_owned), array: array(&[*x], &[1]) };
    FrameFile { name: name.into(), buffers: buffers.iter().map(buffer).collect(), origin: None }
}

#[test]
fn buffers_of_one_name_are_compared() {
    let a = frames("a.npz", &[(Some("color"), 1.0), (Some("depth"), 2.0), (Some("id"), 3.0)]);
    let b = frames("b.exr", &[(Some("depth"), 4.0), (Some("bound"), 5.0), (Some("color"), 6.0)]);
    let found = MatchedBuffers::of(&a, &b, &[]).expect("pairs");
    let names: Vec<_> = found.common.iter().map(|pair| pair.name.expect("a name")).collect();
    assert_eq!((names, found.missing), (vec!["color", "depth"], vec![("id", "a.npz"), ("bound", "b.exr")]));
    assert_eq!(found.common[1].b, &array(&[4.0], &[1]));
    let requested = ["depth".to_owned()];
    let found = MatchedBuffers::of(&a, &b, &requested).expect("pairs");
    assert_eq!((found.common.len(), found.missing.len()), (1, 0));
    let requested = ["id".to_owned()];
    let error = MatchedBuffers::of(&a, &b, &requested).expect_err("b has none").to_string();
    assert!(error.contains("b.exr has no buffer `id`; the file has depth, bound, color"), "{error}");
    // Single buffers are compared whatever their names; a buffer without a name matches none of several.
    let (one, nameless) = (frames("one.npy", &[(Some("depth"), 7.0)]), frames("x.npy", &[(None, 8.0)]));
    assert_eq!(MatchedBuffers::of(&one, &nameless, &[]).expect("a pair").common[0].name, Some("depth"));
    let error = MatchedBuffers::of(&nameless, &b, &[]).expect_err("which").to_string();
    assert!(error.contains("x.npy has an unnamed buffer"), "{error}");
    let requested = ["bound".to_owned()];
    assert_eq!(MatchedBuffers::of(&nameless, &b, &requested).expect("a pair").common[0].b, &array(&[5.0], &[1]));
    let found = MatchedBuffers::of(&one, &b, &[]).expect("a pair");
    assert_eq!((found.common.len(), found.missing.len()), (1, 2));
}

#[test]
fn pfm_of_other_programs_is_read_from_the_bottom_row() {
    let numbers = |big: bool| {
        let each = [1.0_f32, 2.0, 3.0, 4.0, 5.0, 6.0].map(|x| if big { x.to_be_bytes() } else { x.to_le_bytes() });
        each.concat()
    };
    for (head, big) in [("Pf\n3 2\n-1.0\n", false), ("Pf 3\t2 1.0\n", true), ("Pf\n3 2\n-0.5\n", false)] {
        let file = [head.as_bytes(), &numbers(big)].concat();
        let found = FrameFile::from_bytes(&file, "a.pfm").expect(head);
        let expected = Array::new("a.pfm", vec![2, 3], Values::F32(vec![4.0, 5.0, 6.0, 1.0, 2.0, 3.0])).expect("whole");
        assert_eq!(found.buffers, [NamedBuffer { name: None, array: expected }], "{head:?}");
    }
    let colour = [&b"PF\n2 1\n-1\n"[..], &numbers(false)].concat();
    assert_eq!(FrameFile::from_bytes(&colour, "a.pfm").expect("colour").buffers[0].array.shape(), [1, 2, 3]);
    for bad in [
        "Pf\n3 2\n-1.0\n",
        "Pf\n0 2\n-1.0\n",
        "Pf\n3 2\n0\n",
        "PF\n18446744073709551615 9\n-1\n",
        "Pf\n",
        "Pf\n1 1\n-1\n12345",
    ] {
        let error = FrameFile::from_bytes(bad.as_bytes(), "a.pfm").expect_err(bad).to_string();
        assert!(error.starts_with("a.pfm: the PFM file is damaged"), "{error}");
    }
}

#[test]
fn a_file_that_is_not_a_frame_is_refused() {
    for bytes in [&b""[..], b"words", b"PK\x03\x04", b"PK\x05\x06", &[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0], b"\x89PNG"] {
        let error = FrameFile::from_bytes(bytes, "a").expect_err("no frame");
        assert!(matches!(error, Error::Scene { .. }), "{bytes:?}: {error}");
    }
}
