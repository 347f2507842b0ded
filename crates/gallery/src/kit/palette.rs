//! The materials of the town, and how their textures are painted.

use glam::{Affine2, IVec2, Vec2, Vec3, Vec4};
use sheer_core::colour::linear_from_hex;
use sheer_image::Image;
use sheer_scene::model::{AlphaMode, Material, TextureRef};

use crate::{
    builder::SceneBuilder,
    kit::leaf,
    paint::{Fractal, Noise, Spot, Texel, paint, paint_colour, smoothstep, texel_middles},
};

/// Material indices by what they are. Unless it says otherwise a texture tiles, white at its brightest, to be
/// tinted by the vertices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Palette {
    pub(crate) plaster: u32,
    pub(crate) brick: u32,
    pub(crate) ashlar: u32,
    pub(crate) timber: u32,
    pub(crate) planks: u32,
    pub(crate) tiles: u32,
    pub(crate) cobbles: u32,
    pub(crate) slabs: u32,
    pub(crate) meadow: u32,
    pub(crate) bark: u32,
    /// Atlas of 2×2 leaf clusters, cut out.
    pub(crate) leaves: u32,
    /// Atlas of 2×2 window panes: dark room, curtains, blind, lamplight.
    pub(crate) panes: u32,
    /// Stripes along u, one pair a metre of texture.
    pub(crate) awning: u32,
    /// A clock dial that fills the unit square.
    pub(crate) dial: u32,
    /// Painted metal; the vertices give its colour.
    pub(crate) iron: u32,
    /// Bare shiny metal; the vertices give its colour.
    pub(crate) metal: u32,
    pub(crate) water: u32,
    /// Lamp glass that glows faintly.
    pub(crate) lantern: u32,
    /// Embers that glow in a bowl of fire.
    pub(crate) embers: u32,
}

impl Palette {
    /// Adds all materials; the textures of those that stay unused are never painted.
    pub(crate) fn new(builder: &mut SceneBuilder, seed: u32) -> Self {
        let mut easel = Easel { builder, seed };
        let plain = |name: &str, colour: Vec3, roughness: f32, metallic: f32| Material {
            name: name.to_owned(),
            base_colour: colour.extend(1.0),
            roughness,
            metallic,
            ..Material::default()
        };
        let emissive = |name: &str, colour: Vec3, radiance: Vec3| Material {
            emissive: radiance,
            ..plain(name, colour, 0.4, 0.0)
        };
        Self {
            plaster: easel.painted("plaster", 3.0, 512, plaster),
            brick: easel.painted("brick", 2.0, 512, brick),
            ashlar: easel.painted("ashlar", 3.2, 512, ashlar),
            timber: easel.painted("timber", 1.2, 256, timber),
            planks: easel.painted("planks", 1.0, 256, planks),
            tiles: easel.painted("fired clay", 1.5, 256, clay),
            cobbles: easel.painted("cobbles", 2.56, 512, cobbles),
            slabs: easel.painted("slabs", 2.4, 512, slabs),
            meadow: easel.painted("meadow", 4.0, 256, meadow),
            bark: easel.painted("bark", 1.0, 256, bark),
            leaves: easel.cut_out("leaves", move || leaf::leaf_atlas(seed)),
            panes: easel.panes(),
            awning: easel.awning(),
            dial: easel.dial(),
            iron: easel.builder.material(plain("iron", Vec3::ONE, 0.45, 0.0)),
            metal: easel.builder.material(plain("metal", Vec3::ONE, 0.3, 1.0)),
            water: easel.builder.material(plain("water", Vec3::new(0.02, 0.05, 0.05), 0.04, 0.0)),
            lantern: easel.builder.material(emissive("lantern", Vec3::splat(0.8), Vec3::new(1.0, 0.72, 0.4))),
            embers: easel.builder.material(emissive("embers", Vec3::splat(0.05), Vec3::new(6.0, 1.6, 0.3))),
        }
    }
}

/// Adds materials whose textures are painted from one seed.
struct Easel<'a> {
    builder: &'a mut SceneBuilder,
    seed: u32,
}

impl Easel<'_> {
    /// A tiling material whose texture spans `tile_metres`; `prepare` gets the noise that it is made of and
    /// its size.
    fn painted<T: Fn(Spot) -> Texel + Sync + 'static>(
        &mut self,
        name: &str,
        tile_metres: f32,
        size: u32,
        prepare: fn(Noise, u32) -> T,
    ) -> u32 {
        let noise = Noise { seed: self.seed };
        let textures = self.builder.painted_surface(name, move || paint(size, prepare(noise, size)));
        let [colour, normal, surface] = textures.map(|texture| TextureRef {
            transform: Affine2::from_scale(Vec2::splat(1.0 / tile_metres)),
            ..TextureRef::new(texture)
        });
        self.builder.material(Material {
            name: name.to_owned(),
            base_colour_texture: Some(colour),
            normal_texture: Some(normal),
            metallic_roughness_texture: Some(surface),
            occlusion_texture: Some(surface),
            ..Material::default()
        })
    }

    fn cut_out(&mut self, name: &str, paint: impl FnOnce() -> Image<[u8; 4]> + Send + 'static) -> u32 {
        let texture = TextureRef::new(self.builder.texture(name, paint));
        self.builder.material(Material {
            name: name.to_owned(),
            base_colour_texture: Some(texture),
            alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
            roughness: 0.75,
            ..Material::default()
        })
    }

    fn panes(&mut self) -> u32 {
        let noise = Noise { seed: self.seed.wrapping_add(91) };
        let paint = move || {
            let drape = noise.fractal(IVec2::new(3, 2), 2);
            paint_colour(256, |Spot { uv, .. }| (pane(&drape, uv), 1.0))
        };
        let texture = TextureRef::new(self.builder.texture("window panes", paint));
        self.builder.material(Material {
            name: "window panes".to_owned(),
            base_colour_texture: Some(texture),
            roughness: 0.05,
            ..Material::default()
        })
    }

    fn awning(&mut self) -> u32 {
        let noise = Noise { seed: self.seed.wrapping_add(17) };
        let paint = move || {
            let weave = noise.fractal(IVec2::new(32, 32), 2).sheet(256);
            paint_colour(256, |Spot { uv, texel }| {
                let weave = 0.93 + 0.07 * weave[texel];
                let stripe = smoothstep(0.23, 0.26, uv.x) - smoothstep(0.74, 0.77, uv.x);
                (Vec3::ONE.lerp(Vec3::new(0.42, 0.07, 0.05), stripe) * weave, 1.0)
            })
        };
        let texture = TextureRef {
            transform: Affine2::from_scale(Vec2::splat(1.0 / 0.5)),
            ..TextureRef::new(self.builder.texture("awning", paint))
        };
        self.builder.material(Material {
            name: "awning".to_owned(),
            base_colour_texture: Some(texture),
            base_colour: Vec4::new(0.9, 0.87, 0.78, 1.0),
            double_sided: true,
            ..Material::default()
        })
    }

    fn dial(&mut self) -> u32 {
        let paint = || paint_colour(256, |Spot { uv, .. }| (dial(uv), 1.0));
        let texture = TextureRef::new(self.builder.texture("dial", paint));
        self.builder.material(Material {
            name: "dial".to_owned(),
            base_colour_texture: Some(texture),
            roughness: 0.4,
            ..Material::default()
        })
    }
}

fn plaster(noise: Noise, size: u32) -> impl Fn(Spot) -> Texel + Sync {
    let mottles = noise.fractal(IVec2::splat(3), 5).sheet(size);
    let streaks = Noise { seed: noise.seed + 1 }.fractal(IVec2::new(12, 2), 3).sheet(size);
    let grains = Noise { seed: noise.seed + 2 }.fractal(IVec2::splat(48), 2).sheet(size);
    let patches = Noise { seed: noise.seed + 3 }.fractal(IVec2::splat(2), 4).sheet(size);
    move |Spot { texel, .. }| {
        let mottle = mottles[texel];
        let streaks = streaks[texel];
        let grain = grains[texel];
        let patch = smoothstep(0.28, 0.5, patches[texel]);
        let value = 0.88 + 0.07 * mottle + 0.05 * streaks + 0.03 * grain - 0.045 * patch;
        let warmth = Vec3::new(1.0, 0.985, 0.955).lerp(Vec3::new(0.96, 0.95, 0.94), patch);
        Texel {
            height: 0.0004 * grain + 0.0012 * mottle - 0.0006 * patch,
            roughness: 0.92,
            ..Texel::matt(warmth * value)
        }
    }
}

fn brick(noise: Noise, size: u32) -> impl Fn(Spot) -> Texel + Sync {
    let wobbles = noise.fractal(IVec2::splat(40), 2).sheet(size);
    let grains = Noise { seed: noise.seed + 5 }.fractal(IVec2::splat(64), 2).sheet(size);
    let stains = Noise { seed: noise.seed + 6 }.fractal(IVec2::splat(3), 3).sheet(size);
    move |Spot { uv, texel }| {
        const COURSES: f32 = 24.0;
        const COLUMNS: f32 = 8.0;
        let course = (uv.y * COURSES).floor();
        let along = uv.x * COLUMNS + if course as i32 % 2 == 0 { 0.0 } else { 0.5 };
        let column = along.floor();
        // Wobbling joints: no brick is perfect.
        let wobble = 0.06 * wobbles[texel];
        let edge_x = ((along - column) - 0.5).abs() * 2.0;
        let edge_y = ((uv.y * COURSES - course) - 0.5).abs() * 2.0;
        let inside = (1.0 - smoothstep(0.90, 0.98, edge_x + wobble * 0.4))
            * (1.0 - smoothstep(0.70, 0.92, edge_y + wobble));
        let cell = IVec2::new(column as i32, course as i32);
        let period = IVec2::new(COLUMNS as i32, COURSES as i32);
        let (shade, hue) = (noise.lattice(cell, period, 1), noise.lattice(cell, period, 2));
        let grain = grains[texel];
        let stain = stains[texel];
        let clay = linear_from_hex(0xa8583c).lerp(linear_from_hex(0x8a3a2a), hue) * (0.75 + 0.5 * shade);
        let clay = clay.lerp(linear_from_hex(0x4a2a24), smoothstep(0.9, 0.97, hue));
        let mortar = linear_from_hex(0xb5a690) * (0.85 + 0.1 * grain);
        let colour = mortar.lerp(clay * (1.0 + 0.16 * grain), inside) * (1.0 + 0.14 * stain);
        Texel {
            colour,
            height: 0.006 * inside + 0.0012 * grain + 0.0015 * inside * shade,
            roughness: 0.88,
            occlusion: 0.6 + 0.4 * inside,
            alpha: 1.0,
        }
    }
}

fn ashlar(noise: Noise, size: u32) -> impl Fn(Spot) -> Texel + Sync {
    let wobbles = noise.fractal(IVec2::splat(24), 2).sheet(size);
    let grains = Noise { seed: noise.seed + 8 }.fractal(IVec2::splat(40), 3).sheet(size);
    let stains = Noise { seed: noise.seed + 9 }.fractal(IVec2::splat(4), 4).sheet(size);
    move |Spot { uv, texel }| {
        let rows = 8.0;
        let row = (uv.y * rows).floor();
        let along = uv.x * 4.0 + 0.5 * (row as i32 % 2) as f32 + 0.12 * ((row as i32 % 4) as f32 - 1.5);
        let column = along.floor();
        let wobble = 0.012 * wobbles[texel];
        let edge = (0.5 - ((along - column) - 0.5).abs()) * 0.8;
        let edge = edge.min((0.5 - ((uv.y * rows - row) - 0.5).abs()) * 0.4) + wobble;
        let inside = smoothstep(0.004, 0.022, edge);
        let shade = noise.lattice(IVec2::new(column as i32, row as i32), IVec2::new(4, 8), 1);
        let grain = grains[texel];
        let stain = stains[texel];
        let stone =
            Vec3::new(0.80, 0.75, 0.66).lerp(Vec3::new(0.68, 0.64, 0.58), shade) * (1.0 + 0.08 * grain);
        let colour = stone * (1.0 + 0.13 * stain) * (0.5 + 0.5 * inside);
        Texel {
            colour,
            height: 0.0035 * inside + 0.0014 * grain,
            roughness: 0.85,
            occlusion: 0.6 + 0.4 * inside,
            alpha: 1.0,
        }
    }
}

fn timber(noise: Noise, size: u32) -> impl Fn(Spot) -> Texel + Sync {
    let bends = noise.fractal(IVec2::splat(3), 2).sheet(size);
    let grains = noise.fractal(IVec2::new(40, 2), 3);
    let checks = Noise { seed: noise.seed + 11 }.fractal(IVec2::new(24, 3), 2).sheet(size);
    move |Spot { uv, texel }| {
        let grain = grains.at(uv + Vec2::new(0.02 * bends[texel], 0.0));
        let check = smoothstep(0.35, 0.6, checks[texel]);
        let value = 0.72 + 0.22 * grain - 0.35 * check;
        Texel {
            height: 0.003 * grain - 0.006 * check,
            roughness: 0.8,
            ..Texel::matt(Vec3::new(1.0, 0.94, 0.88) * value)
        }
    }
}

fn planks(noise: Noise, _: u32) -> impl Fn(Spot) -> Texel + Sync {
    const COUNT: u32 = 8;
    // Each is of other wood.
    let grains = [0, 1, 2, 3, 4, 5, 6, 7]
        .map(|plank| Noise { seed: noise.seed + plank }.fractal(IVec2::new(48, 2), 3));
    move |Spot { uv, .. }| {
        let count = COUNT as f32;
        let plank = (uv.x * count).floor();
        let edge = 0.5 - ((uv.x * count - plank) - 0.5).abs();
        let inside = smoothstep(0.01, 0.07, edge);
        let shade = noise.lattice(IVec2::new(plank as i32, 0), IVec2::new(8, 1), 4);
        let grain = grains[plank as usize].at(uv);
        let value = (0.78 + 0.16 * shade + 0.14 * grain) * (0.25 + 0.75 * inside);
        Texel {
            height: 0.006 * inside + 0.0015 * grain,
            occlusion: 0.5 + 0.5 * inside,
            roughness: 0.7,
            ..Texel::matt(Vec3::new(1.0, 0.96, 0.9) * value)
        }
    }
}

fn clay(noise: Noise, size: u32) -> impl Fn(Spot) -> Texel + Sync {
    let mottles = noise.fractal(IVec2::splat(6), 4).sheet(size);
    let lichens = Noise { seed: noise.seed + 21 }.fractal(IVec2::splat(9), 3).sheet(size);
    move |Spot { texel, .. }| {
        let mottle = mottles[texel];
        let lichen = smoothstep(0.30, 0.55, lichens[texel]);
        let colour = Vec3::splat(0.85 + 0.15 * mottle).lerp(Vec3::new(0.62, 0.62, 0.48), 0.55 * lichen);
        Texel { height: 0.0015 * mottle, roughness: 0.85, ..Texel::matt(colour) }
    }
}

fn cobbles(noise: Noise, size: u32) -> impl Fn(Spot) -> Texel + Sync {
    const COUNT: i32 = 20;
    let warp = noise.fractal(IVec2::splat(5), 2);
    // The same noise twice, so far apart that it does not show.
    let elsewhere: Vec<f32> = texel_middles(size).into_iter().map(|at| at + 0.37).collect();
    let warps = [warp.sheet(size), warp.coarse_sheet(&elsewhere, &elsewhere, 2)];
    let stones = Noise { seed: noise.seed + 31 }.cells(IVec2::splat(COUNT), 0.5);
    let grains = Noise { seed: noise.seed + 32 }.fractal(IVec2::splat(80), 2).sheet(size);
    let dirt = Noise { seed: noise.seed + 33 }.fractal(IVec2::splat(4), 3).sheet(size);
    move |Spot { uv, texel }| {
        let warp = Vec2::new(warps[0][texel], warps[1][texel]) * 0.02;
        let cell = stones.at((uv + warp) * COUNT as f32);
        let stone = smoothstep(0.02, 0.17, cell.border);
        let dome = (1.0 - (cell.nearest * 1.35).powi(2)).max(0.0);
        let grain = grains[texel];
        let dirt = dirt[texel];
        let tones = [
            Vec3::new(0.42, 0.37, 0.31),
            Vec3::new(0.31, 0.29, 0.275),
            Vec3::new(0.47, 0.40, 0.31),
            Vec3::new(0.38, 0.32, 0.27),
        ];
        let tone = tones[(cell.id * 3.999) as usize] * (0.8 + 0.4 * (cell.id * 7.0).fract());
        let sand = Vec3::new(0.20, 0.17, 0.13) * (1.0 + 0.2 * grain);
        let colour = sand.lerp(tone * (1.0 + 0.15 * grain), stone) * (1.0 + 0.10 * dirt);
        Texel {
            colour,
            height: 0.0075 * stone * (0.45 + 0.55 * dome) + 0.0006 * grain,
            roughness: 0.95 - 0.35 * stone * dome,
            occlusion: 0.45 + 0.55 * stone,
            alpha: 1.0,
        }
    }
}

fn slabs(noise: Noise, size: u32) -> impl Fn(Spot) -> Texel + Sync {
    let wobbles = noise.fractal(IVec2::splat(30), 2).sheet(size);
    let grains = Noise { seed: noise.seed + 41 }.fractal(IVec2::splat(60), 2).sheet(size);
    let stains = Noise { seed: noise.seed + 42 }.fractal(IVec2::splat(5), 4).sheet(size);
    move |Spot { uv, texel }| {
        let row = (uv.y * 4.0).floor();
        let along = uv.x * 3.0 + 0.5 * (row as i32 % 2) as f32;
        let column = along.floor();
        let edge = (0.5 - ((along - column) - 0.5).abs()) * 0.8;
        let edge = edge.min((0.5 - ((uv.y * 4.0 - row) - 0.5).abs()) * 0.6) + 0.004 * wobbles[texel];
        let inside = smoothstep(0.004, 0.014, edge);
        let shade = noise.lattice(IVec2::new(column as i32, row as i32), IVec2::new(3, 4), 1);
        let grain = grains[texel];
        let stain = stains[texel];
        let colour =
            Vec3::new(0.50, 0.47, 0.42) * (0.82 + 0.28 * shade) * (1.0 + 0.08 * grain + 0.16 * stain);
        Texel {
            colour: colour * (0.45 + 0.55 * inside),
            height: 0.003 * inside + 0.0005 * grain,
            roughness: 0.8 - 0.1 * shade,
            occlusion: 0.55 + 0.45 * inside,
            alpha: 1.0,
        }
    }
}

fn meadow(noise: Noise, size: u32) -> impl Fn(Spot) -> Texel + Sync {
    let patches = noise.fractal(IVec2::splat(5), 4).sheet(size);
    let blades = Noise { seed: noise.seed + 51 }.fractal(IVec2::splat(60), 2).sheet(size);
    move |Spot { texel, .. }| {
        let patch = patches[texel];
        let blades = blades[texel];
        let colour =
            Vec3::new(0.16, 0.22, 0.06).lerp(Vec3::new(0.30, 0.29, 0.12), smoothstep(-0.3, 0.6, patch));
        Texel { height: 0.004 * blades, ..Texel::matt(colour * (1.0 + 0.3 * blades)) }
    }
}

fn bark(noise: Noise, size: u32) -> impl Fn(Spot) -> Texel + Sync {
    let twists = noise.fractal(IVec2::splat(4), 2).sheet(size);
    let ridges = noise.fractal(IVec2::new(10, 3), 4);
    move |Spot { uv, texel }| {
        let twist = Vec2::new(0.03 * twists[texel], 0.0);
        let ridges = ridges.at(uv + twist);
        let furrow = smoothstep(-0.15, 0.25, ridges);
        let value = 0.35 + 0.65 * furrow + 0.1 * ridges;
        Texel {
            height: 0.018 * furrow + 0.006 * ridges,
            occlusion: 0.5 + 0.5 * furrow,
            ..Texel::matt(Vec3::new(0.27, 0.215, 0.165) * value)
        }
    }
}

/// A room seen through a window, in four quarters of the texture: dark, curtained, with a blind half drawn,
/// and lamplit.
fn pane(drape: &Fractal, uv: Vec2) -> Vec3 {
    let quarter = (uv * 2.0).floor();
    let p = uv * 2.0 - quarter;
    let room = Vec3::new(0.030, 0.034, 0.040) * (1.0 + 0.5 * (1.0 - p.y));
    let folds = 0.75 + 0.25 * (p.x * 55.0 + 2.0 * drape.at(p)).sin();
    let drawn_back = 0.17 + 0.10 * p.y * p.y;
    let curtain = smoothstep(0.0, 0.02, drawn_back - (0.5 - (p.x - 0.5).abs()));
    match (quarter.x as u32, quarter.y as u32) {
        (0, 0) => room,
        (1, 0) => room.lerp(Vec3::new(0.55, 0.52, 0.47) * folds, curtain),
        (0, 1) => {
            let blind = 1.0 - smoothstep(0.46, 0.47, p.y);
            room.lerp(Vec3::new(0.50, 0.44, 0.33) * (0.9 + 0.1 * (p.y * 120.0).sin()), blind)
        }
        _ => room.lerp(Vec3::new(0.40, 0.14, 0.10) * folds, curtain),
    }
}

/// A white clock dial with dark bars and hands at ten past five.
fn dial(uv: Vec2) -> Vec3 {
    let p = uv * 2.0 - 1.0;
    let radius = p.length();
    let angle = p.x.atan2(-p.y) / std::f32::consts::TAU;
    let hour = (angle * 12.0 - (angle * 12.0).round()).abs() / 12.0 * std::f32::consts::TAU * radius;
    let bar = f32::from(hour < 0.03 && (0.70..0.88).contains(&radius));
    let ring = smoothstep(0.90, 0.92, radius);
    let hand = |turn: f32, length: f32, width: f32| {
        let (sin, cos) = (turn * std::f32::consts::TAU).sin_cos();
        let (along, across) = (p.x * sin - p.y * cos, p.x * cos + p.y * sin);
        f32::from((-0.1..length).contains(&along) && across.abs() < width * (1.0 - 0.5 * along / length))
    };
    let dark = bar.max(ring).max(hand(5.17 / 12.0, 0.48, 0.055)).max(hand(10.0 / 60.0, 0.72, 0.04));
    Vec3::new(0.85, 0.82, 0.74).lerp(Vec3::new(0.03, 0.03, 0.035), dark)
}
