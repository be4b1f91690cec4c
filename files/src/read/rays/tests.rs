use super::*;
use halfline::progress::Watch;
use halfline_particles::npy::header::Header;
use std::io::Cursor;

fn open(bytes: impl Into<Vec<u8>>, skip_invalid: bool) -> Result<RayReader> {
    let options = RayOptions { skip_invalid, watch: Watch::default() };
    RayReader::from_reader(Cursor::new(bytes.into()), Path::new("rays"), &options)
}

/// All rows in blocks of `most`.
fn read(bytes: impl Into<Vec<u8>>, skip_invalid: bool, most: usize) -> Result<RayBlock> {
    let (mut reader, mut all) = (open(bytes, skip_invalid)?, RayBlock::default());
    while let Some(block) = reader.next_block(most)? {
        assert!(block.rows() <= most);
        all.append(block);
    }
    Ok(all)
}

fn array(dtype: &str, shape: &[u64], values: &[f64]) -> Vec<u8> {
    let mut bytes = Header::bytes(dtype, shape);
    for x in values {
        match dtype {
            "<f4" => bytes.extend((*x as f32).to_le_bytes()),
            ">f8" => bytes.extend(x.to_be_bytes()),
            _ => bytes.extend(x.to_le_bytes()),
        }
    }
    bytes
}

/// The error of reading, in words.
fn refused(bytes: impl Into<Vec<u8>>) -> String {
    let error = read(bytes, false, 100).map(drop).expect_err("an error");
    assert!(matches!(error, Error::Scene { .. }), "{error}");
    error.to_string()
}

#[test]
fn an_array_is_read_in_blocks_of_any_size() {
    let values: Vec<f64> = (1..=70).map(f64::from).collect();
    for (dtype, width) in [("<f8", 7), (">f8", 7), ("<f4", 7), ("<f8", 6)] {
        let rows = values.len() / width;
        let bytes = array(dtype, &[rows as u64, width as u64], &values[..rows * width]);
        assert_eq!(open(bytes.clone(), false).expect("an array").count(), Some(rows as u64));
        for most in [1, 3, 1000] {
            let rays = read(bytes.clone(), false, most).expect("an array");
            assert_eq!((rays.rows(), rays.limits.len()), (rows, if width == 7 { rows } else { 0 }));
            for (row, numbers) in values.chunks_exact(width).take(rows).enumerate() {
                assert_eq!(rays.origins[row], numbers[..3]);
                assert_eq!(rays.directions[row], numbers[3..6]);
                assert_eq!(rays.limits.get(row), numbers.get(6));
            }
        }
    }
    assert_eq!(read(array("<f8", &[0, 6], &[]), false, 9).expect("no rows").rows(), 0);
}

#[test]
fn an_array_that_is_none_of_rays_is_refused() {
    let six = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    for (bytes, message) in [
        (array("<f8", &[1, 5], &six[..5]), "rays: shape: found (1, 5), expected (n, 6) or (n, 7)"),
        (array("<f8", &[6], &six), "rays: shape"),
        (array("<c8", &[1, 6], &six), "rays: dtype: found `<c8`, expected integers or floats of at most 8 bytes"),
        (array("<f8", &[2, 6], &six), "rays: data: the file ends after 1 of 2 rows"),
        (array("<f8", &[1, 6], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]), "rays: data: bytes follow"),
        (b"PK\x03\x04".to_vec(), "archive"),
        (b"\x93NUMPY\x01\x00\x03\x00{}\n".to_vec(), "rays: header"),
    ] {
        let error = refused(bytes);
        assert!(error.contains(message), "{error}");
    }
    let mut columns = array("<f8", &[2, 6], &[six, six].concat());
    let flag = columns.windows(5).position(|text| text == b"False").expect("the order");
    columns[flag..flag + 5].copy_from_slice(b"True ");
    assert!(refused(columns).contains("ascontiguousarray"));
}

#[test]
fn tables_have_any_delimiter_and_named_columns_any_order() {
    for text in [
        "ox,oy,oz,dx,dy,dz,tmax\n1,2,3,4,5,6,7\n0.5,-2e3,3,4,5,6,inf\n",
        "1,2,3,4,5,6,7\n0.5,-2e3,3,4,5,6,inf",
        "1 2 3 4 5 6 7\n\n# a comment\n  0.5 -2e3 3  4 5 6 inf\r\n",
        "# ox oy oz dx dy dz tmax\n1;2;3;4;5;6;7\n0.5;-2e3;3;4;5;6;inf",
        "\u{feff}# made by hand, for a test\nTMAX\tDX\tDY\tDZ\tOX\tOY\tOZ\n7\t4\t5\t6\t1\t2\t3\ninf\t4\t5\t6\t0.5\t-2e3\t3\n",
        "#tmax,dx,dy,dz,ox,oy,oz\n7,4,5,6,1,2,3\n\"inf\", 4,5,6,0.5,-2e3,3\n",
    ] {
        for most in [1, 100] {
            let rays = read(text, false, most).unwrap_or_else(|error| panic!("{error}: {text}"));
            assert_eq!(rays.origins, [[1.0, 2.0, 3.0], [0.5, -2e3, 3.0]], "{text}");
            assert_eq!(rays.directions, [[4.0, 5.0, 6.0]; 2], "{text}");
            assert_eq!(rays.limits, [7.0, f64::INFINITY], "{text}");
        }
    }
    let six = read("dx,dy,dz,ox,oy,oz\n1,2,3,4,5,6\n", false, 9).expect("six columns");
    assert_eq!((six.directions[0], six.origins[0], six.limits.len()), ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], 0));
    assert_eq!(read("ox,oy,oz,dx,dy,dz\n", false, 9).expect("no rows").rows(), 0);
}

#[test]
fn a_table_that_is_none_of_rays_is_refused_at_its_place() {
    for (text, message) in [
        ("", "rays: the file has no rays"),
        ("# only a comment\n\n", "rays: the file has no rays"),
        ("ox,oy,oz,dx,dy\n1,2,3,4,5\n", "rays:1:1: header: column `dz` is missing"),
        ("ox,oy,oz,dx,dy,dz,t\n", "rays:1:19: header: unknown column `t`"),
        ("ox,oy,oz,dx,dy,dx\n", "rays:1:16: header: `dx` occurs twice"),
        ("1,2,3,4,5\n", "rays:1:1: found 5 numbers in a row, expected 6 or 7"),
        ("1,2,3,4,5,6\n1,2,3,4,5\n", "rays:2:10: dz: expected 6 numbers, found 5"),
        ("1,2,3,4,5,6\n\n1,2,3,4,5,6,7\n", "rays:3:13: row: the row has more than the 6 numbers"),
        ("1,2,3,4,5,6\n1,2,x,4,5,6\n", "rays:2:5: oz: `x` is not a number"),
        ("1,2,3,4,5,6\n1,2,3,0,0,0\n", "rays:2:1: direction: the direction is zero"),
        ("1,2,3,4,5,6\n1,nan,3,0,0,1\n", "rays:2:1: origin: a coordinate is not finite"),
        ("1,2,3,4,5,6,1\n1,2,3,0,0,1,nan\n", "rays:2:1: tmax: the limit is NaN"),
    ] {
        let error = refused(text);
        assert!(error.contains(message), "{error}");
    }
    assert!(refused(b"1,2,3,4,5,6\n1,2,3,4,5,\xff\n".to_vec()).contains("rays:2:11"));
}

#[test]
fn invalid_rows_are_named_or_left_out() {
    let (good, inf, nan) = ([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], f64::INFINITY, f64::NAN);
    let with = |place: usize, x: f64| {
        let mut row = good;
        row[place] = x;
        row
    };
    let zero = [1.0, 2.0, 3.0, 0.0, -0.0, 0.0, 7.0];
    let rows = [good, with(1, nan), with(6, -inf), with(3, inf), zero, with(6, nan), with(6, 0.0), good];
    let bytes = array("<f8", &[8, 7], &rows.concat());
    assert!(refused(bytes.clone()).contains("rays: row 1 (from 0) origin: a coordinate is not finite"));
    assert!(refused(array("<f8", &[1, 7], &zero)).contains("row 0 (from 0) direction: the direction is zero"));
    let line = |row: &[f64; 7]| row.map(|x| x.to_string()).join(",") + "\n";
    let text: String = rows.iter().map(line).collect::<String>() + "1,2\na,b,c,d,e,f,g\n";
    for most in [1, 3, 100] {
        let rays = read(bytes.clone(), true, most).expect("an array");
        assert_eq!((rays.rows(), &rays.invalid[..]), (8, &[1, 3, 4, 5][..]));
        assert_eq!(rays.limits, [7.0, -inf, 0.0, 7.0]);
        let fault = rays.fault.expect("what is wrong").to_string();
        assert!(fault.contains("row 1 (from 0) origin"), "{fault}");
        let rays = read(&text[..], true, most).expect("a table");
        assert_eq!((rays.rows(), &rays.invalid[..]), (10, &[1, 3, 4, 5, 8, 9][..]));
        let fault = rays.fault.expect("what is wrong").to_string();
        assert!(fault.contains("rays:2:1: origin"), "{fault}");
    }
}

/// Several blocks of lines, parsed on all cores.
#[test]
fn a_long_table_keeps_its_order() {
    let row = |n: usize| if n % 1000 == 7 { "0,0,0,0,0,0\n".to_owned() } else { format!("{n},0.5,-1,1,0,0\n") };
    let text: String = (0..200_000).map(row).collect();
    let rays = read(&text[..], true, 70_000).expect("a table");
    assert_eq!((rays.rows(), rays.invalid.len()), (200_000, 200));
    let (mut rest, mut at) = (rays.origins.iter(), 0);
    for n in 0..200_000u32 {
        if rays.invalid.get(at) == Some(&n) {
            at += 1;
            assert_eq!(n % 1000, 7);
        } else {
            assert_eq!(rest.next(), Some(&[f64::from(n), 0.5, -1.0]));
        }
    }
    let error = read(&text[..], false, 70_000).map(drop).expect_err("a row").to_string();
    assert!(error.contains("rays:8:1: direction"), "{error}");
}
