//! `index.html` of `sheer metrics`.

use serde::Serialize;
use sheer_image::{Image, Metadata, Picture, Tone, display, encode_png};
use sheer_lab::{ERROR_FULL_SCALE, Figures, Judged, Seeded, picture_figures};

use super::{
    data_uri, fill,
    viewer::{Card, legend},
};
use crate::report::json::JudgedPictures;

/// Pictures with their error maps as PNG, encoded once, for their files and for the page.
#[derive(Debug)]
pub(crate) struct Page<'a> {
    reference: (&'a str, Vec<u8>),
    judged: &'a [Seeded<Judged>],
    /// Picture and error map of each, with its first seed.
    pngs: Vec<[Vec<u8>; 2]>,
}

/// What the template fills in.
#[derive(Serialize)]
struct Context<'a> {
    run: &'a JudgedPictures<'a>,
    figures: Figures,
    cards: Vec<Card>,
    legend: String,
    error_full_scale: f32,
}

impl<'a> Page<'a> {
    /// Encodes the pictures.
    ///
    /// # Errors
    /// There is no memory for them.
    pub(crate) fn new(
        name: &'a str,
        reference: &Picture,
        tone: Tone,
        judged: &'a [Seeded<Judged>],
    ) -> anyhow::Result<Self> {
        let png = |image: &Image<[u8; 4]>| encode_png(image, &Metadata::default());
        let both = |judged: &Judged| Ok([png(&judged.picture)?, png(&judged.error_map)?]);
        Ok(Self {
            reference: (name, png(&display(&reference.colour, tone, &reference.share))?),
            judged,
            pngs: judged.iter().map(Seeded::first).map(both).collect::<anyhow::Result<_>>()?,
        })
    }

    /// The pictures with what they are called.
    pub(crate) fn files(&self) -> impl Iterator<Item = (String, &[u8])> {
        let (name, png) = &self.reference;
        let judged = self.judged.iter().map(Seeded::first);
        let of_judged = judged.zip(&self.pngs).flat_map(|(judged, [picture, error])| {
            [(judged.name.clone(), picture.as_slice()), (format!("{}-error", judged.name), error.as_slice())]
        });
        std::iter::once((format!("reference-{name}"), png.as_slice())).chain(of_judged)
    }

    /// The page as text.
    ///
    /// # Errors
    /// If the template is broken, which the tests would have found.
    pub(crate) fn text(&self, report: &JudgedPictures<'_>) -> anyhow::Result<String> {
        let card = |id: usize, label: &str, picture: &[u8], error: Option<&Vec<u8>>| Card {
            id: format!("picture-{id}"),
            label: label.to_owned(),
            aa: String::new(),
            is_reference: error.is_none(),
            picture: data_uri(picture),
            error: error.map(|png| data_uri(png)),
        };
        let (name, png) = &self.reference;
        let mut cards = vec![card(0, name, png, None)];
        cards.extend(
            (1..)
                .zip(self.judged)
                .zip(&self.pngs)
                .map(|((id, judged), [picture, error])| card(id, &judged.first().name, picture, Some(error))),
        );
        fill(
            "pictures.html",
            Context {
                run: report,
                figures: picture_figures(self.judged),
                cards,
                legend: legend(),
                error_full_scale: ERROR_FULL_SCALE,
            },
        )
    }
}
