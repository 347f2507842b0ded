//! The constants of all shaders, made from the Rust constants that the CPU uses: no number stands in two
//! places.

use std::f32::consts;

use sheer_core::{
    hash, mask,
    parameter::{Choice as _, ParameterInfo, ParameterRange},
    spatio_temporal, threshold_map,
};
use sheer_render::{
    Antialiasing, Method,
    contract::{self, AlignmentRule, CORRECTION_PARAMETER, ShaderConstant, ShaderValue},
    cpu::shade,
    shadow,
};
use sheer_scene::environment::{self, panorama};

use super::{
    binding,
    constant::{Constant, Value},
    declaration::ShaderType,
    numbers,
    record::{
        pixel::{Counts, FragmentStats, Tested},
        scene,
    },
};
use crate::tables;

/// Rows `module::{NAME, NAME as OTHER_NAME}`: each constant of a module under its own name, or another one in
/// shaders.
macro_rules! constants {
    ($($module:ident :: {$($name:ident $(as $other:ident)?),+ $(,)?}),+ $(,)?) => {
        vec![$($(Constant::new(constants!(@name $name $($other)?), $module::$name)),+),+]
    };
    (@name $name:ident) => { stringify!($name) };
    (@name $name:ident $other:ident) => { stringify!($other) };
}

/// What all shaders may use.
pub(crate) fn all() -> Vec<Constant> {
    let mut all = constants![
        contract::{MIN_ALPHA, DENSE_VISIBILITY, MIN_VISIBILITY, BLUE_NOISE_SIDE},
        numbers::{
            MISS, NO_DEPTH, FAR_AWAY, EPSILON, LEAST_NORMAL, GREATEST, LARGEST_HALF, LIST_END, GROUP_SIDE, PROBE_GROUP,
            BACKGROUND_ENVIRONMENT, BACKGROUND_COLOUR, BACKGROUND_NONE,
        },
        sheer_scene::{
            OPAQUE, SINGLE_SIDED, MIRRORED, TINTED, SLOT, NO_TEXTURE, LEAST_GRAZING, HEAD_ON, MOST_PROBES, LEAST_GAP,
            NEXT_LEVEL,
        },
        hash::{
            LCG_MULTIPLIER, LCG_INCREMENT, PCG_MULTIPLIER, PCG_INCREMENT, PCG_OUTPUT_MULTIPLIER, UNIT_STEP, BELOW_ONE,
            PCG32_MULTIPLIER, SPLITMIX64_STEP,
            MCGUIRE_GAIN, MCGUIRE_X, MCGUIRE_Y, MCGUIRE_Y_OF_WEIGHT, MCGUIRE_LEAST,
        },
        mask::{ALPHA_BITS, OPAQUE as OPAQUE_ALPHA, CURVE_SIDE},
        threshold_map::{SIDE as MAP_SIDE},
        spatio_temporal::{SIDE as RANK_SIDE, FRAME_COUNT as RANK_FRAMES, COUNT as RANK_COUNT},
        shade::{
            DIELECTRIC_F0, MIN_ROUGHNESS, SMOKE_WRAP, SMOKE_ANISOTROPY,
            FIBRE_SURFACE, FIBRE_THROUGH, FIBRE_BACK, FIBRE_TILT, FIBRE_THROUGH_FIT, FIBRE_BACK_FIT, SMOKE_SHARES,
            SPECULAR_FIT_SLOPES, SPECULAR_FIT_STARTS, SPECULAR_FIT_FALL, SPECULAR_FIT_GRAZING,
            LEAST_COSINE, LEAST_CONE, LEAST_SQUARE_DISTANCE,
        },
        environment::{HORIZON_BLUR, LEAST_WIDTH, GROUND_STEEPNESS},
        panorama::{LEVEL_SHARP, ROUGHNESS_STEPS, LEVEL_DIFFUSE, ANGLE_FIT, ANGLE_FIT_END},
        shadow::{LIFT_ROUNDING},
        consts::{PI},
        tables::{TABLE_STD_MAPS, TABLE_BLUE_NOISE, TABLE_DECODE},
    ];
    all.extend([
        Constant::new("MASK_WIDTH", mask::WIDTH as u32),
        Constant::new("MAP_COUNT", threshold_map::MAP_COUNT as u32),
        Constant::new("THRESHOLD_COUNT", threshold_map::THRESHOLD_COUNT as u32),
    ]);
    let rules = (0_u32..).zip(AlignmentRule::WORDS);
    all.extend(rules.map(|(number, rule)| Constant::new(format!("ALIGN_{}", word(rule)), number)));
    all.extend(
        [scene::CONSTANTS, binding::ALL].concat().into_iter().map(|(name, value)| Constant::new(name, value)),
    );
    all.extend(word_indices());
    let factors = hash::SPLITMIX64_FACTORS.into_iter().enumerate();
    all.extend(factors.map(|(index, factor)| Constant::new(format!("SPLITMIX64_FACTOR_{index}"), factor)));
    let scramble = mask::SCRAMBLE.into_iter().enumerate();
    all.extend(scramble.map(|(index, factor)| Constant::new(format!("SCRAMBLE_{index}"), factor)));
    all
}

/// For structs that shaders see as an array of words, since they are changed by several invocations at a
/// time: their length and the index of each member.
fn word_indices() -> Vec<Constant> {
    let mut constants = Vec::new();
    for (prefix, declaration) in [
        ("COUNTER", Counts::declaration()),
        ("STATS", FragmentStats::declaration()),
        ("TESTED", Tested::declaration()),
    ] {
        let declaration = declaration.expect("a struct has a declaration");
        constants.push(Constant::new(format!("{prefix}_WORDS"), declaration.size as u32 / 4));
        let indices = declaration.word_indices(prefix).into_iter();
        constants.extend(indices.map(|(name, index)| Constant::new(name, index)));
    }
    constants
}

/// A method's parameters, its own constants and where its tables begin. The key `rehash` becomes `P_REHASH`,
/// a choice `hash` becomes `P_HASH`, the number of the word chosen, with `P_HASH_PCG` and `P_HASH_MCGUIRE` to
/// compare with.
pub(crate) fn of_method(method: &Method) -> Vec<Constant> {
    // A correction has coefficients in place of its word, which a fitted one does not have.
    let parameters = method.parameters();
    let mut constants: Vec<Constant> = parameters
        .iter()
        .filter(|parameter| parameter.key != CORRECTION_PARAMETER.key)
        .flat_map(|parameter| of_parameter(parameter, method.value(parameter.key)))
        .collect();
    constants.extend([
        Constant {
            name: "P_CORRECTION_COEFFICIENTS".to_owned(),
            value: Value::Vec4F(method.correction().coefficients()),
        },
        Constant::new("P_ALIGNMENT_PX", method.alignment().side_px),
    ]);
    constants.extend(method.info().constants.iter().map(of_constant));
    constants.extend(tables::of_method(method.info().tables));
    constants
}

/// The parameters of an anti-aliasing technique, named as those of methods are, and its own constants.
pub(crate) fn of_antialiasing(antialiasing: &Antialiasing) -> Vec<Constant> {
    let info = antialiasing.info();
    let parameters = info.parameters.iter().zip(antialiasing.values());
    let mut constants: Vec<Constant> =
        parameters.flat_map(|(parameter, (_, value))| of_parameter(parameter, &value)).collect();
    constants.extend(info.constants.iter().map(of_constant));
    constants
}

/// A constant that a method or a technique declares.
pub(crate) fn of_constant(constant: &ShaderConstant) -> Constant {
    let value = match constant.value {
        ShaderValue::U32(value) => Value::U32(value),
        ShaderValue::I32(value) => Value::I32(value),
        ShaderValue::F32(value) => Value::F32(value),
        ShaderValue::Vec4F(values) => Value::Vec4F(values),
    };
    Constant { name: constant.name.to_owned(), value }
}

/// A parameter's value, which has been checked against its range.
fn of_parameter(parameter: &ParameterInfo, value: &str) -> Vec<Constant> {
    let name = format!("P_{}", word(parameter.key));
    match parameter.range {
        ParameterRange::Count(..) => {
            vec![Constant::new(name, value.parse::<u32>().expect("checked against its range"))]
        }
        ParameterRange::Real(..) => {
            vec![Constant::new(name, value.parse::<f32>().expect("checked against its range"))]
        }
        ParameterRange::Choice(words) => {
            let chosen = words.iter().position(|word| *word == value).expect("checked against its range");
            let numbered = (0_u32..).zip(words);
            let named =
                numbered.map(|(number, each)| Constant::new(format!("{name}_{}", word(each)), number));
            [Constant::new(name.clone(), chosen as u32)].into_iter().chain(named).collect()
        }
    }
}

/// A key or a word as a part of a constant's name.
fn word(text: &str) -> String {
    text.to_ascii_uppercase().replace(|letter: char| !letter.is_ascii_alphanumeric(), "_")
}

#[cfg(test)]
mod tests {
    use naga::{Expression, Handle, Literal, Module};
    use sheer_core::coverage::Correction;
    use sheer_render::{method::METHODS, temporal::ANTIALIASINGS};

    use super::*;
    use crate::shader::constant::text;

    fn bits(module: &Module, init: Handle<Expression>) -> Vec<u32> {
        match &module.global_expressions[init] {
            Expression::Literal(Literal::Bool(value)) => vec![u32::from(*value)],
            Expression::Literal(Literal::U32(value)) => vec![*value],
            Expression::Literal(Literal::I32(value)) => vec![value.cast_unsigned()],
            Expression::Literal(Literal::F32(value)) => vec![value.to_bits()],
            Expression::Compose { components, .. } => {
                components.iter().flat_map(|component| bits(module, *component)).collect()
            }
            other => panic!("{other:?} is no constant"),
        }
    }

    /// What naga's constant evaluator makes of a text, name by name.
    fn read_back(text: &str) -> Vec<(String, Vec<u32>)> {
        let module = naga::front::wgsl::parse_str(text)
            .unwrap_or_else(|error| panic!("{}", error.emit_to_string(text)));
        let named =
            module.constants.iter().filter_map(|(_, constant)| Some((constant.name.clone()?, constant.init)));
        named.map(|(name, init)| (name, bits(&module, init))).collect()
    }

    fn expected(constants: &[Constant]) -> Vec<(String, Vec<u32>)> {
        let bits = |value| match value {
            Value::Bool(value) => vec![u32::from(value)],
            Value::U32(value) => vec![value],
            Value::I32(value) => vec![value.cast_unsigned()],
            Value::F32(value) => vec![value.to_bits()],
            Value::U64(value) => vec![value as u32, (value >> 32) as u32],
            Value::Vec2F(values) => values.map(f32::to_bits).to_vec(),
            Value::Vec4F(values) => values.map(f32::to_bits).to_vec(),
        };
        constants.iter().map(|constant| (constant.name.clone(), bits(constant.value))).collect()
    }

    #[test]
    fn a_shader_reads_the_same_bits_of_every_constant() {
        let constants = all();
        assert_eq!(read_back(&text(&constants)), expected(&constants));
        // Negative control: the next float is another constant.
        let mut off = constants;
        off.push(Constant::new("CONTROL", 0.1_f32));
        let written = text(&off);
        off.last_mut().unwrap().value = Value::F32(0.1_f32.next_up());
        assert_ne!(read_back(&written), expected(&off));
    }

    #[test]
    fn floats_of_every_size_read_back_the_same_bits() {
        let mut random = hash::Pcg32::new(3, 0);
        let drawn = (0..2000).map(|_| f32::from_bits(random.next_u32())).filter(|value| value.is_normal());
        let extremes = [0.0, -0.0, 1.0, f32::MAX, f32::MIN, f32::MIN_POSITIVE, hash::BELOW_ONE];
        let constants: Vec<Constant> = (0..)
            .zip(drawn.chain(extremes))
            .map(|(index, value): (u32, f32)| Constant::new(format!("C{index}"), value))
            .collect();
        assert_eq!(read_back(&text(&constants)), expected(&constants));
    }

    #[test]
    fn the_constants_of_every_method_and_every_anti_aliasing_read_back() {
        for info in METHODS {
            let constants = of_method(&info.id.parse().unwrap());
            assert_eq!(read_back(&text(&constants)), expected(&constants), "{}", info.id);
        }
        for info in ANTIALIASINGS {
            let constants = of_antialiasing(&info.id.parse().unwrap());
            assert_eq!(read_back(&text(&constants)), expected(&constants), "{}", info.id);
        }
    }

    #[test]
    fn parameters_are_named_after_key_and_word() {
        let method: Method = "std:hash=mcguire,rehash=9,hybrid=0.1,align=off".parse().unwrap();
        let fitted = Correction::new([0.1, 0.2, 0.3, 0.4]).unwrap();
        let text = text(&of_method(&method.with_correction(fitted, "std:correction=fitted.json")));
        for line in [
            "const P_HASH: u32 = 1u;",
            "const P_HASH_PCG: u32 = 0u;",
            "const P_HASH_MCGUIRE: u32 = 1u;",
            "const P_REHASH: u32 = 9u;",
            "const P_HYBRID: f32 = 0.1f;",
            "const P_LAYERS: u32 = 0u;",
            "const P_ALIGNMENT_PX: u32 = 1u;",
            "const P_CORRECTION_COEFFICIENTS: vec4f = vec4f(0.1f, 0.2f, 0.3f, 0.4f);",
        ] {
            assert!(text.lines().any(|written| written == line), "{line} is not in\n{text}");
        }
    }
}
