//! The promise of messages that name an option to add, to use or to remove: the command with it does what was asked for.

use crate::test_dir::TestDir;

const TABLE: &str = "x,y,z,radius,speed,kind\n0,0,0,1,0.5,a\n2,0,0,0.7,1.5,b\n0,2,0,0.5,2.5,a\n";
const SCENE: &str = "[camera]\neye = [0, 0, 5]\nat = [0, 0, 0]\nup = [0, 1, 0]\nvfov = 40\n[image]\nsize = [32, 24]\n\
                     [[sphere]]\ncenter = [0, 0, 0]\nradius = 1\n";
const LENS: &str = r#"{"fl_x": 30, "fl_y": 30, "k1": 0.1, "w": 32, "h": 24,
    "frames": [{"transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,9],[0,0,0,1]]}]}"#;

/// Commands that are refused with a mend.
const REFUSED: [&str; 20] = [
    "t.csv --map batlow -o a.png",
    "t.csv --nan-color red -o a.png",
    "t.csv --color-by kind --log -o a.png",
    "t.csv --color-by kind --range 0,1 -o a.png",
    "t.csv --shine 10 -o a.png",
    "t.csv --focus-distance 3 -o a.png",
    "t.csv --eye 0,0,9 --ortho --at 0,0,0 -o a.png",
    "t.csv --fps 10 -o a.png",
    "t.csv --dpi 300 -o a.exr",
    "t.csv --label x --crop 0,0,9,9 -o a.png",
    "t.csv --mark all=x --tile 1/4 -o a.png",
    "t.csv --legend-in -o a.png",
    "t.csv --altloc highest -o a.png",
    "t.csv --assembly 1 -o a.png",
    "t.csv --as-listed -o a.png",
    "t.csv --cryptomatte id --opacity 0.5 -o a.exr",
    "s.toml --reach 2 --look plain -o a.png",
    "s.toml --aov shadow=s.npy",
    "s.toml --method stable --accuracy certified -o a.png",
    "t.csv --cameras lens.json --aperture 0.1 --samples 4 -o a.png",
];

/// The value of a place in a message.
fn value(place: &str) -> Option<&str> {
    Some(match place {
        "COLUMN" => "speed",
        "D" => "0.5",
        "N" => "9",
        "HEIGHT" => "6",
        "X,Y,Z" => "1,2,3",
        "'EXPR=COLOR'" => "x>0=red",
        word if word.chars().all(|c| c.is_ascii_lowercase()) => word,
        _ => return None,
    })
}

/// The command without an option.
fn without(words: &[String], option: &str) -> Vec<String> {
    let mut left = words.to_vec();
    if let Some(at) = left.iter().position(|word| word == option) {
        let has_value = left.get(at + 1).is_some_and(|next| !next.starts_with("--") && next != "-o");
        left.drain(at..=at + usize::from(has_value));
    }
    left
}

/// The commands that the mend of a message stands for.
fn mended(words: &[String], message: &str) -> Vec<Vec<String>> {
    let (_, mend) = message.trim().rsplit_once("; ").unwrap_or_default();
    let mut verb = "";
    let mut all = Vec::new();
    for clause in mend.split(", ").flat_map(|part| part.split(" or ")) {
        let clause: Vec<&str> = clause.split_whitespace().filter(|word| *word != "or").collect();
        let rest = match clause.first() {
            Some(first @ (&"add" | &"use" | &"remove")) => {
                verb = first;
                &clause[1..]
            }
            _ => &clause[..],
        };
        let Some(option) = rest.first().filter(|word| word.starts_with("--")) else { continue };
        let is_given = words.iter().any(|word| word == option);
        let mut words = without(words, option);
        if verb == "remove" && !is_given {
            continue;
        }
        if verb != "remove" {
            words.push((*option).to_owned());
            if let Some(place) = rest.get(1) {
                let Some(value) = value(place) else { continue };
                words.push(value.to_owned());
            }
            if *option == "--aov" && rest.get(1).is_some() {
                let buffer = words.pop().unwrap_or_default();
                words.push(format!("{buffer}=m.npy"));
            }
        }
        all.push(words);
    }
    all
}

#[test]
fn the_mends_of_messages_do() {
    let dir = TestDir::new(&[("t.csv", TABLE), ("s.toml", SCENE), ("lens.json", LENS)]);
    let mut tried = 0;
    for line in REFUSED {
        let words: Vec<String> = format!("render {line} --backend cpu").split(' ').map(str::to_owned).collect();
        let ran = dir.run(&words);
        assert_eq!(ran.code, 2, "{line}: {}", ran.err);
        let message = ran.err.lines().rfind(|line| line.contains("; ")).unwrap_or_default();
        let all = mended(&words, message);
        assert!(!all.is_empty(), "{line}: no mend in {message}");
        for command in all {
            let ran = dir.run(&command);
            assert_eq!(ran.code, 0, "{message}\n{}: {}", command.join(" "), ran.err);
            tried += 1;
        }
    }
    assert!(tried >= REFUSED.len(), "{tried} mends");
}
