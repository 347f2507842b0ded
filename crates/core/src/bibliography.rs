//! The works that Sheer cites, in one table. Comments name a work by its authors and year, or by an
//! abbreviation that is defined here; `docs/bibliography.md` is this table as a page.

use std::fmt;

/// A published work as a list of references has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Work {
    /// What it is called for short, where it is cited often.
    pub abbreviation: Option<&'static str>,
    /// Names as a list of references has them, family names first; in the order of the publication.
    pub authors: &'static [&'static str],
    /// Title in its own capitals.
    pub title: &'static str,
    /// Journal with volume, conference, publisher or site.
    pub venue: &'static str,
    /// The year of publication.
    pub year: u16,
}

impl Work {
    /// Family name of the first author.
    #[must_use]
    pub fn first_author(&self) -> &'static str {
        let first = self.authors.first().copied().unwrap_or_default();
        first.split(',').next().unwrap_or_default()
    }
}

impl fmt::Display for Work {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { abbreviation, authors, title, venue, year } = self;
        if let Some(abbreviation) = abbreviation {
            write!(f, "**{abbreviation}**: ")?;
        }
        let authors = authors.join("; ");
        write!(f, "{}. *{title}*. {venue}, {year}.", authors.trim_end_matches('.'))
    }
}

/// Rows `NAME, abbreviation: authors, title, venue, year`.
macro_rules! works {
    ($($name:ident $(, $abbreviation:literal)? : [$($author:literal),+ $(,)?], $title:literal, $venue:literal, $year:literal;)+) => {
        $(
            #[doc = $title]
            pub const $name: Work = Work {
                abbreviation: works!(@option $($abbreviation)?),
                authors: &[$($author),+],
                title: $title,
                venue: $venue,
                year: $year,
            };
        )+

        /// All works, by first author and year.
        pub const WORKS: &[Work] = &[$($name),+];
    };
    (@option $abbreviation:literal) => { Some($abbreviation) };
    (@option) => { None };
}

works! {
    AKENINE_MOELLER_2019: ["Akenine-Möller, T.", "Nilsson, J.", "Andersson, M.", "Barré-Brisebois, C.", "Toth, R.", "Karras, T."],
        "Texture Level of Detail Strategies for Real-Time Ray Tracing", "Ray Tracing Gems, Apress", 2019;
    ANDREW_1979: ["Andrew, A. M."],
        "Another efficient algorithm for convex hulls in two dimensions", "Information Processing Letters 9 (5)", 1979;
    BAVOIL_2007: ["Bavoil, L.", "Callahan, S. P.", "Lefohn, A.", "Comba, J. L. D.", "Silva, C. T."],
        "Multi-Fragment Effects on the GPU Using the k-Buffer", "Interactive 3D Graphics and Games (I3D)", 2007;
    STD, "STD": ["Brüll, F.", "Kern, R.", "Grosch, T."],
        "Spatio-Temporal Dithering for Order-Independent Transparency on Ray Tracing Hardware",
        "Eurographics Symposium on Rendering (EGSR)", 2025;
    CARPENTER_1984: ["Carpenter, L."],
        "The A-buffer, an Antialiased Hidden Surface Method", "SIGGRAPH", 1984;
    CASTANO_2010: ["Castaño, I."],
        "Computing Alpha Mipmaps", "the-witness.net", 2010;
    ST, "ST": ["Enderton, E.", "Sintorn, E.", "Shirley, P.", "Luebke, D."],
        "Stochastic Transparency", "IEEE Transactions on Visualization and Computer Graphics 17 (8)", 2011;
    EPIC_DITHER: ["Epic Games"],
        "DitherTemporalAA", "material function of Unreal Engine 4", 2014;
    EVERITT_2001: ["Everitt, C."],
        "Interactive Order-Independent Transparency", "NVIDIA", 2001;
    GUTHE_HECKBERT_2005: ["Guthe, S.", "Heckbert, P."],
        "Non-Power-of-Two Mipmap Creation", "NVIDIA", 2005;
    HAINES_GREENBERG_1986: ["Haines, E. A.", "Greenberg, D. P."],
        "The Light Buffer: A Shadow-Testing Accelerator", "IEEE Computer Graphics and Applications 6 (9)", 1986;
    HENYEY_GREENSTEIN_1941: ["Henyey, L. G.", "Greenstein, J. L."],
        "Diffuse radiation in the Galaxy", "The Astrophysical Journal 93", 1941;
    IZE_2013: ["Ize, T."],
        "Robust BVH Ray Traversal", "Journal of Computer Graphics Techniques 2 (2)", 2013;
    JANSEN_BAVOIL_2010: ["Jansen, J.", "Bavoil, L."],
        "Fourier Opacity Mapping", "Interactive 3D Graphics and Games (I3D)", 2010;
    JARZYNSKI_OLANO_2020: ["Jarzynski, M.", "Olano, M."],
        "Hash Functions for GPU Rendering", "Journal of Computer Graphics Techniques 9 (3)", 2020;
    JOHNSON_KOTZ_1970: ["Johnson, N. L.", "Kotz, S."],
        "Continuous Univariate Distributions", "Wiley", 1970;
    KAJIYA_KAY_1989: ["Kajiya, J. T.", "Kay, T. L."],
        "Rendering Fur with Three Dimensional Textures", "SIGGRAPH", 1989;
    KARIS_2014: ["Karis, B."],
        "Physically Based Shading on Mobile", "Unreal Engine blog", 2014;
    KARIS_2016: ["Karis, B."],
        "Physically Based Hair Shading in Unreal", "SIGGRAPH course Physically Based Shading in Theory and Practice", 2016;
    KOLCHIN_1978: ["Kolchin, V. F.", "Sevastyanov, B. A.", "Chistyakov, V. P."],
        "Random Allocations", "Winston", 1978;
    LAINE_KARRAS_2011: ["Laine, S.", "Karras, T."],
        "Stratified Sampling for Stochastic Transparency", "Computer Graphics Forum 30 (4)", 2011;
    LEE_1980: ["Lee, J.-S."],
        "Digital Image Enhancement and Noise Filtering by Use of Local Statistics",
        "IEEE Transactions on Pattern Analysis and Machine Intelligence 2 (2)", 1980;
    LEMIRE_2019: ["Lemire, D."],
        "Fast Random Integer Generation in an Interval", "ACM Transactions on Modeling and Computer Simulation 29 (1)", 2019;
    LIU_2010: ["Liu, F.", "Huang, M.-C.", "Liu, X.-H.", "Wu, E.-H."],
        "FreePipe: a Programmable Parallel Rendering Architecture for Efficient Multi-Fragment Effects",
        "Interactive 3D Graphics and Games (I3D)", 2010;
    LOKOVIC_VEACH_2000: ["Lokovic, T.", "Veach, E."],
        "Deep Shadow Maps", "SIGGRAPH", 2000;
    MAMMEN_1989: ["Mammen, A."],
        "Transparency and Antialiasing Algorithms Implemented with the Virtual Pixel Maps Technique",
        "IEEE Computer Graphics and Applications 9 (4)", 1989;
    MANTIUK_2024: ["Mantiuk, R. K.", "Hanji, P.", "Ashraf, M.", "Asano, Y.", "Chapiro, A."],
        "ColorVideoVDP: A visual difference predictor for image, video and display distortions",
        "ACM Transactions on Graphics 43 (4)", 2024;
    MARSCHNER_2003: ["Marschner, S. R.", "Jensen, H. W.", "Cammarano, M.", "Worley, S.", "Hanrahan, P."],
        "Light Scattering from Human Hair Fibers", "ACM Transactions on Graphics 22 (3)", 2003;
    MCGUIRE_CODEX: ["McGuire, M."],
        "The Graphics Codex", "Casual Effects, edition 2.13", 2014;
    MCGUIRE_BAVOIL_2013: ["McGuire, M.", "Bavoil, L."],
        "Weighted Blended Order-Independent Transparency", "Journal of Computer Graphics Techniques 2 (2)", 2013;
    MCGUIRE_ENDERTON_2011: ["McGuire, M.", "Enderton, E."],
        "Colored Stochastic Shadow Maps", "Interactive 3D Graphics and Games (I3D)", 2011;
    MOELLER_TRUMBORE_1997: ["Möller, T.", "Trumbore, B."],
        "Fast, Minimum Storage Ray/Triangle Intersection", "Journal of Graphics Tools 2 (1)", 1997;
    MORTON_1966: ["Morton, G. M."],
        "A Computer Oriented Geodetic Data Base and a New Technique in File Sequencing", "IBM", 1966;
    MUENSTERMANN_2018: ["Münstermann, C.", "Krumpen, S.", "Klein, R.", "Peters, C."],
        "Moment-Based Order-Independent Transparency",
        "Proceedings of the ACM on Computer Graphics and Interactive Techniques 1 (1)", 2018;
    ONEILL_2014: ["O'Neill, M. E."],
        "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms for Random Number Generation",
        "Harvey Mudd College", 2014;
    OTTOSSON_2020: ["Ottosson, B."],
        "A perceptual color space for image processing", "bottosson.github.io", 2020;
    PERLIN_2002: ["Perlin, K."],
        "Improving Noise", "ACM Transactions on Graphics 21 (3)", 2002;
    PETERS_KLEIN_2015: ["Peters, C.", "Klein, R."],
        "Moment Shadow Mapping", "Interactive 3D Graphics and Games (I3D)", 2015;
    PORTER_DUFF_1984: ["Porter, T.", "Duff, T."],
        "Compositing Digital Images", "SIGGRAPH", 1984;
    ROBERTS_2018: ["Roberts, M."],
        "The Unreasonable Effectiveness of Quasirandom Sequences", "extremelearning.com.au", 2018;
    SALVI_2011: ["Salvi, M.", "Montgomery, J.", "Lefohn, A."],
        "Adaptive Transparency", "High Performance Graphics (HPG)", 2011;
    SALVI_VAIDYANATHAN_2014: ["Salvi, M.", "Vaidyanathan, K."],
        "Multi-Layer Alpha Blending", "Interactive 3D Graphics and Games (I3D)", 2014;
    SALVI_2016: ["Salvi, M."],
        "An Excursion in Temporal Supersampling", "Game Developers Conference (GDC)", 2016;
    STEELE_2014: ["Steele, G. L.", "Lea, D.", "Flood, C. H."],
        "Fast Splittable Pseudorandom Number Generators", "OOPSLA", 2014;
    THOMPSON_BARNETT_1986: ["Thompson, I. J.", "Barnett, A. R."],
        "Coulomb and Bessel functions of complex arguments and order", "Journal of Computational Physics 64 (2)", 1986;
    ULICHNEY_1993: ["Ulichney, R."],
        "The void-and-cluster method for dither array generation", "Human Vision, Visual Processing and Digital Display IV", 1993;
    WALD_2007: ["Wald, I."],
        "On fast Construction of SAH-based Bounding Volume Hierarchies", "IEEE Symposium on Interactive Ray Tracing", 2007;
    WANG_2004: ["Wang, Z.", "Bovik, A. C.", "Sheikh, H. R.", "Simoncelli, E. P."],
        "Image Quality Assessment: From Error Visibility to Structural Similarity",
        "IEEE Transactions on Image Processing 13 (4)", 2004;
    WANG_2009: ["Wang, J.", "Ren, P.", "Gong, M.", "Snyder, J.", "Guo, B."],
        "All-Frequency Rendering of Dynamic, Spatially-Varying Reflectance", "ACM Transactions on Graphics 28 (5)", 2009;
    WELFORD_1962: ["Welford, B. P."],
        "Note on a Method for Calculating Corrected Sums of Squares and Products", "Technometrics 4 (3)", 1962;
    WILLIAMS_1983: ["Williams, L."],
        "Pyramidal Parametrics", "SIGGRAPH", 1983;
    WOLFE_2022: ["Wolfe, A.", "Morrical, N.", "Akenine-Möller, T.", "Ramamoorthi, R."],
        "Spatiotemporal Blue Noise Masks", "Eurographics Symposium on Rendering (EGSR)", 2022;
    WOOP_2013: ["Woop, S.", "Benthin, C.", "Wald, I."],
        "Watertight Ray/Triangle Intersection", "Journal of Computer Graphics Techniques 2 (1)", 2013;
    WORLEY_1996: ["Worley, S."],
        "A Cellular Texture Basis Function", "SIGGRAPH", 1996;
    WYMAN_MCGUIRE_2017: ["Wyman, C.", "McGuire, M."],
        "Hashed Alpha Testing", "Interactive 3D Graphics and Games (I3D)", 2017;
    YANG_2010: ["Yang, J. C.", "Hensley, J.", "Grün, H.", "Thibieroz, N."],
        "Real-Time Concurrent Linked List Construction on the GPU", "Computer Graphics Forum 29 (4)", 2010;
    YUKSEL_KEYSER_2008: ["Yuksel, C.", "Keyser, J."],
        "Deep Opacity Maps", "Computer Graphics Forum 27 (2)", 2008;
}

/// The table as a page of Markdown.
#[must_use]
pub fn page() -> String {
    let mut page = "# Bibliography\n\nThe works that Sheer cites: `WORKS` in `crates/core/src/bibliography.rs` as a page.\n\n".to_owned();
    for work in WORKS {
        page.push_str(&format!("* {work}\n"));
    }
    page
}

#[cfg(test)]
mod tests {
    use std::{fs, path::Path};

    use super::*;

    #[test]
    fn the_page_in_the_docs_is_the_table() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/bibliography.md");
        let written = fs::read_to_string(&path).unwrap_or_default();
        // `SHEER_BLESS=1 cargo test -p sheer-core bibliography` writes it anew.
        if written != page() && std::env::var_os("SHEER_BLESS").is_some() {
            return fs::write(&path, page()).unwrap();
        }
        assert!(written == page(), "{} is not the table: set SHEER_BLESS=1 to write it anew", path.display());
    }

    #[test]
    fn works_stand_in_the_order_of_authors_and_years_and_abbreviations_name_one() {
        let plain = |name: &str| name.to_lowercase().replace('ö', "oe").replace('ü', "ue").replace('\'', "");
        let keys: Vec<(String, u16)> =
            WORKS.iter().map(|work| (plain(work.first_author()), work.year)).collect();
        let names: Vec<&String> = keys.iter().map(|(name, _)| name).collect();
        assert!(names.is_sorted(), "{names:?}");
        let mut abbreviations: Vec<_> = WORKS.iter().filter_map(|work| work.abbreviation).collect();
        abbreviations.sort_unstable();
        assert_eq!(abbreviations, ["ST", "STD"]);
    }
}
