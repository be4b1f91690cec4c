//! Gaussian splats as spheres, after Kerbl, Kopanas, Leimkühler and Drettakis, "3D Gaussian Splatting for Real-Time Radiance Field
//! Rendering" (2023): a vertex has the logarithms of three standard deviations, the colour as spherical harmonics, and the logit of
//! its opacity. Splats of 2D Gaussian Splatting (Huang et al. 2024) have two standard deviations, isotropic ones one, and nerfstudio
//! writes plain colours on request (`--ply-color-mode rgb`).

use crate::color::srgb_to_linear;
use crate::particles::colors::ColorType;
use crate::particles::layout::Layout;
use crate::particles::role::Role;
use halfline_ground::check::is_radius;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::setting::HIDE;

const HARMONICS: [&str; 3] = ["f_dc_0", "f_dc_1", "f_dc_2"];
const SCALES: [&str; 3] = ["scale_0", "scale_1", "scale_2"];
const OPACITY: &str = "opacity";

/// The position of compressed splats, whose vertices have no x, y and z.
pub(super) const PACKED: &str = "packed_position";

/// The constant spherical harmonic, 1 / (2 sqrt(pi)).
const CONSTANT: f64 = 0.282_094_791_773_878_14;

/// The places of a splat's numbers among the numbers of a vertex.
pub(super) struct Splat {
    /// None where the vertices have colours.
    harmonics: Option<[usize; 3]>,
    /// One for each axis that has a size.
    scales: Vec<usize>,
    opacity: Option<usize>,
}

impl Splat {
    /// The splats of vertices with these numbers, by their names, whose colours and radii become columns of the layout behind
    /// them, as far as they have none of their own; `None` for points that are no splats, or have radii of their own.
    pub(super) fn of(names: &[String], layout: &mut Layout) -> Result<Option<Self>, String> {
        let place = |name: &str| names.iter().position(|found| found == name);
        if place(PACKED).is_some() {
            return Err(format!(
                "the property {PACKED} is of Gaussian splats as PlayCanvas and SuperSplat compress them"
            ));
        }
        let scales: Vec<usize> = SCALES.iter().map_while(|name| place(name)).collect();
        let has_colors = layout.contains(Role::Color(0));
        let all = |of: [&str; 3]| Some([place(of[0])?, place(of[1])?, place(of[2])?]);
        let harmonics = all(HARMONICS).filter(|_| !has_colors);
        let is_splat = all(HARMONICS).is_some() || has_colors && place("rot_0").is_some();
        if !is_splat || scales.is_empty() || layout.contains(Role::Radius) || layout.contains(Role::Diameter) {
            return Ok(None);
        }
        let colors = ["red", "green", "blue"].into_iter().zip([0, 1, 2].map(Role::Color));
        let added = colors.filter(|_| harmonics.is_some()).chain([("radius", Role::Radius)]);
        for (name, role) in added {
            layout.add(name, role)?;
        }
        let color = if harmonics.is_some() { "the constant part of its colour" } else { "its colour" };
        let size = match scales.len() {
            1 => "its standard deviation".to_owned(),
            count => {
                format!("the geometric mean of its {} standard deviations", if count == 2 { "two" } else { "three" })
            }
        };
        let note = format!(
            "the points are Gaussian splats: each is an opaque sphere of {color}, and its radius is {size}; {HIDE} leaves out faint \
             ones by the column opacity"
        );
        if harmonics.is_some() {
            layout.note(ColorType::Real, vec![note])
        } else {
            layout.warn(note)
        }
        Ok(Some(Self { harmonics, scales, opacity: place(OPACITY) }))
    }

    /// Adds the colour in linear light and the radius to the numbers of a vertex, and makes its opacity a share.
    ///
    /// # Errors
    /// [`Error::Scene`] at the field for numbers that are not finite, and for a radius beyond f64.
    pub(super) fn complete(&self, numbers: &mut Vec<f64>) -> Result<()> {
        let refuse = |field: &str, x: f64| {
            Error::scene(
                Place::field(field),
                format!("a splat has {x}"),
                "remove the splat, or give it a finite number",
            )
        };
        for (name, k) in HARMONICS.into_iter().zip(self.harmonics.into_iter().flatten()) {
            if !numbers[k].is_finite() {
                return Err(refuse(name, numbers[k]));
            }
            // Values as trained on pictures in sRGB.
            let level = (0.5 + CONSTANT * numbers[k]).clamp(0.0, 1.0);
            numbers.push(srgb_to_linear(level as f32, 1.0).into());
        }
        let mean = self.scales.iter().map(|k| numbers[*k] / self.scales.len() as f64).sum::<f64>();
        let radius = mean.exp();
        if !is_radius(&radius) {
            return Err(refuse("scale_0", numbers[self.scales[0]]));
        }
        numbers.push(radius);
        if let Some(k) = self.opacity {
            numbers[k] = 1.0 / (1.0 + (-numbers[k]).exp());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::particles::frame::Particles;
    use crate::particles::request::Request;
    use crate::source::Source;
    use halfline_ground::error::Result;

    const FIELDS: [&str; 14] = [
        "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1",
        "rot_2", "rot_3",
    ];

    /// A file with these fields and this row of numbers, as text and in binary.
    fn files(fields: &[&str], row: &[f32]) -> [Vec<u8>; 2] {
        let header = |format: &str| {
            let properties: String = fields.iter().map(|field| format!("property float {field}\n")).collect();
            format!("ply\nformat {format} 1.0\nelement vertex 1\n{properties}end_header\n")
        };
        let text: Vec<String> = row.iter().map(f32::to_string).collect();
        let binary = row.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
        [
            format!("{}{}\n", header("ascii"), text.join(" ")).into_bytes(),
            [header("binary_little_endian").into_bytes(), binary].concat(),
        ]
    }

    fn read(bytes: &[u8]) -> Result<Particles> {
        super::super::read(Source::of_bytes(bytes), &Request::of(&["opacity", "scale_0"])).map(Particles::linearized)
    }

    /// The standard deviations 1, 2 and 4; the harmonics give 0.5 in sRGB, more than 1, and less than 0.
    #[test]
    fn a_splat_is_a_sphere_with_the_constant_part_of_its_colour() {
        let row = [1.0, 2.0, 3.0, 0.0, 2.0, -2.0, 0.0, 0.0, 2f32.ln(), 4f32.ln(), 1.0, 0.0, 0.0, 0.0];
        for bytes in files(&FIELDS, &row) {
            let found = read(&bytes).expect("a splat");
            assert_eq!(found.positions, [[1.0, 2.0, 3.0]]);
            // The logarithms are rounded to float32.
            assert!((found.radii[0] - 2.0).abs() < 1e-6, "{:?}", found.radii);
            // IEC 61966-2-1 of 0.5: ((0.5 + 0.055) / 1.055)^2.4.
            let [red, green, blue] = found.colors[0];
            assert!((red - 0.214_041_14).abs() < 1e-7 && (green, blue) == (1.0, 0.0), "{:?}", found.colors);
            assert_eq!(found.columns.iter().map(|column| column.values[0]).collect::<Vec<_>>(), [0.5, 0.0]);
            assert!(found.skipped.assumed.iter().any(|note| note.contains("Gaussian splats")));
        }
        // Colours and radii of their own stay.
        let with = [&FIELDS[..], &["red", "green", "blue", "radius"]].concat();
        for bytes in files(&with, &[&row[..], &[0.25, 0.5, 0.75, 9.0]].concat()) {
            let found = read(&bytes).expect("a sphere");
            assert_eq!((found.colors, found.radii), (vec![[0.25, 0.5, 0.75]], vec![9.0]));
            assert!(found.skipped.assumed.is_empty(), "{:?}", found.skipped.assumed);
        }
    }

    /// Splats of other trainers: two and one standard deviations, without an opacity, and with plain colours.
    #[test]
    fn splats_of_other_trainers_are_taken_or_refused_by_name() {
        let row = [1.0, 2.0, 3.0, 0.0, 2.0, -2.0, 0.0, 2f32.ln(), 8f32.ln()];
        for (count, radius, size) in [(2, 4.0, "of its two standard"), (1, 2.0, "is its standard deviation;")] {
            let fields = [&FIELDS[..6], &FIELDS[7..7 + count]].concat();
            let numbers = [&row[..6], &row[7..7 + count]].concat();
            for bytes in files(&fields, &numbers) {
                let found = read(&bytes).expect("a splat");
                assert!((found.radii[0] - radius).abs() < 1e-5 && found.colors.len() == 1, "{:?}", found.radii);
                assert!(found.skipped.assumed.iter().any(|note| note.contains(size)), "{:?}", found.skipped.assumed);
            }
        }
        let fields = ["x", "y", "z", "red", "green", "blue", "opacity", "scale_0", "scale_1", "scale_2", "rot_0"];
        for bytes in files(&fields, &[1.0, 2.0, 3.0, 0.25, 0.5, 0.75, 0.0, 0.0, 2f32.ln(), 4f32.ln(), 1.0]) {
            let found = read(&bytes).expect("a splat");
            assert!((found.radii[0] - 2.0).abs() < 1e-6 && found.colors == [[0.25, 0.5, 0.75]], "{found:?}");
        }
        let error = files(&["packed_position", "packed_scale"], &[1.0, 2.0]).map(|bytes| read(&bytes).map(drop));
        for error in error {
            let error = error.expect_err("compressed").to_string();
            assert!(error.contains("packed_position is of Gaussian splats") && error.contains("SuperSplat"), "{error}");
        }
    }

    /// Trainings write splats that are none.
    #[test]
    fn invalid_splats_are_left_out_on_request() {
        let row = [1.0f32, 2.0, 3.0, 0.0, 2.0, -2.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
        for (k, x) in
            [(0, f32::NAN), (2, f32::INFINITY), (3, f32::NAN), (5, f32::NEG_INFINITY), (8, f32::NAN), (9, 1e30)]
        {
            let mut bad = row;
            bad[k] = x;
            for bytes in files(&FIELDS, &[&row[..], &bad, &row].concat()) {
                let text = String::from_utf8_lossy(&bytes).replace("vertex 1\n", "vertex 3\n");
                let bytes = match text.contains("ascii") {
                    true => {
                        let (head, rows) = text.split_once("end_header\n").expect("a header");
                        let words: Vec<&str> = rows.split_whitespace().collect();
                        let rows: Vec<String> = words.chunks(FIELDS.len()).map(|row| row.join(" ")).collect();
                        format!("{head}end_header\n{}\n", rows.join("\n")).into_bytes()
                    }
                    false => {
                        let at = bytes.windows(9).position(|text| text == b"vertex 1\n").expect("a count");
                        [&bytes[..at], b"vertex 3\n", &bytes[at + 9..]].concat()
                    }
                };
                let read = |skip_invalid| {
                    let request = Request { skip_invalid, ..Request::default() };
                    super::super::read(Source::of_bytes(&bytes), &request)
                };
                let found = read(true).unwrap_or_else(|error| panic!("{} {x}: {error}", FIELDS[k]));
                assert_eq!(
                    (found.positions.len(), found.radii.len(), found.colors.len()),
                    (2, 2, 2),
                    "{} {x}",
                    FIELDS[k]
                );
                let notes = &found.skipped.assumed;
                assert!(notes.iter().any(|note| note.starts_with("1 row left out, the first")), "{notes:?}");
                let error = read(false).map(drop).expect_err("a splat").to_string();
                assert!(error.contains("`\u{2060}skip_invalid`"), "{error}");
            }
        }
    }

    #[test]
    fn a_splat_without_a_size_or_a_colour_is_an_error_at_its_field() {
        let row = [1.0f32, 2.0, 3.0, 0.0, 2.0, -2.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
        for (k, x, field) in
            [(4, f32::NAN, "f_dc_1"), (7, f32::INFINITY, "scale_0"), (8, 1e4, "scale_0"), (9, -1e4, "scale_0")]
        {
            let mut row = row;
            row[k] = x;
            for bytes in files(&FIELDS, &row) {
                let error = read(&bytes).map(drop).expect_err(field).to_string();
                assert!(error.contains(field) && error.contains("a splat has"), "{error}");
            }
        }
    }
}
