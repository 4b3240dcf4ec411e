//! Optical constants of named materials.
//!
//! The names are those of the Mitsuba 3 scene format. Dielectrics: refractive index near 589 nm at room temperature
//! (mostly Hecht, Optics). Conductors: complex index from spectra by Palik (Handbook of Optical Constants of Solids)
//! and others, integrated against the CIE observer and converted to linear sRGB with negative components clamped, as is
//! usual in RGB renderers.

use crate::color::Rgb;
use glam::Vec3;

/// Refractive index of a transparent material, by name; case does not matter.
pub fn dielectric_ior(name: &str) -> Option<f32> {
    DIELECTRICS
        .iter()
        .find(|(known, _)| known.eq_ignore_ascii_case(name))
        .map(|&(_, ior)| ior)
}

/// The complex index (eta, k) of a metal or semiconductor, by name, in any case. `none` is a perfect mirror.
///
/// The suffix `_palik` asks for Palik's measurement, which most entries are anyway.
pub fn conductor_ior(name: &str) -> Option<(Rgb, Rgb)> {
    let find = |name: &str| {
        CONDUCTORS
            .iter()
            .find(|(known, ..)| known.eq_ignore_ascii_case(name))
            .map(|&(_, eta, k)| (eta, k))
    };
    find(name).or_else(|| find(name.strip_suffix("_palik")?))
}

/// Refractive indices by name.
pub const DIELECTRICS: [(&str, f32); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("air", 1.000_277),
    ("carbon dioxide", 1.000_45),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.520_45),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];

/// The complex indices (eta, k) by name, linear Rec. 709.
pub const CONDUCTORS: [(&str, Rgb, Rgb); 42] = [
    ("none", Vec3::ZERO, Vec3::ONE),
    (
        "a-C",
        Vec3::new(2.9440458, 2.2271364, 1.9681617),
        Vec3::new(0.8874649, 0.7992985, 0.81529),
    ),
    (
        "Ag",
        Vec3::new(0.1552762, 0.116727956, 0.13838764),
        Vec3::new(4.8283544, 3.1222224, 2.1469011),
    ),
    (
        "Al",
        Vec3::new(1.6575009, 0.8804047, 0.52124447),
        Vec3::new(9.223811, 6.269502, 4.837004),
    ),
    (
        "AlAs",
        Vec3::new(3.605296, 3.2329378, 2.2163186),
        Vec3::new(0.0006794373, 0.0, 0.007512709),
    ),
    (
        "AlSb",
        Vec3::new(0.0, 4.1393747, 4.6692543),
        Vec3::new(0.0, 0.09400908, 1.30057),
    ),
    (
        "Au",
        Vec3::new(0.14303598, 0.37530708, 1.4420453),
        Vec3::new(3.982997, 2.3855565, 1.6033592),
    ),
    (
        "Be",
        Vec3::new(4.1850123, 3.1850293, 2.7840612),
        Vec3::new(3.835466, 3.0101223, 2.868994),
    ),
    (
        "Cr",
        Vec3::new(4.3696675, 2.9165053, 1.6549046),
        Vec3::new(5.206547, 4.231306, 3.7546988),
    ),
    (
        "CsI",
        Vec3::new(2.1448996, 1.7023189, 1.6624272),
        Vec3::new(0.0, 0.0, 0.0),
    ),
    (
        "Cu",
        Vec3::new(0.20100547, 0.9237495, 1.1022154),
        Vec3::new(3.9132621, 2.4530451, 2.1420898),
    ),
    (
        "Cu2O",
        Vec3::new(3.5517726, 2.9498696, 2.7518754),
        Vec3::new(0.11420702, 0.19389686, 0.6061339),
    ),
    (
        "Cu_palik",
        Vec3::new(0.21322851, 0.9197154, 1.1024108),
        Vec3::new(3.9218733, 2.4573317, 2.136584),
    ),
    (
        "CuO",
        Vec3::new(3.247541, 2.4478052, 2.2102196),
        Vec3::new(0.52108955, 0.57003075, 0.72217894),
    ),
    (
        "d-C",
        Vec3::new(2.7087197, 2.3188257, 2.2288976),
        Vec3::new(0.0, 0.0, 0.0),
    ),
    (
        "Hg",
        Vec3::new(2.3989387, 1.440028, 0.9095704),
        Vec3::new(6.327587, 4.371925, 3.4217637),
    ),
    (
        "HgTe",
        Vec3::new(4.77904, 3.2311962, 2.6599011),
        Vec3::new(1.6316127, 1.5808104, 1.7292874),
    ),
    (
        "Ir",
        Vec3::new(3.0863, 2.0821905, 1.6179146),
        Vec3::new(5.592153, 4.067088, 3.267312),
    ),
    (
        "K",
        Vec3::new(0.06404319, 0.046409767, 0.038184915),
        Vec3::new(2.1041996, 1.34894, 0.9131259),
    ),
    (
        "Li",
        Vec3::new(0.26579094, 0.19561832, 0.22094862),
        Vec3::new(3.540155, 2.3111234, 1.6686072),
    ),
    (
        "MgO",
        Vec3::new(2.0895839, 1.6507235, 1.594879),
        Vec3::new(4.3326952e-12, 0.0, 2.4986457e-11),
    ),
    (
        "Mo",
        Vec3::new(4.483974, 3.5251307, 2.7763104),
        Vec3::new(4.1114373, 3.420827, 3.1506073),
    ),
    (
        "Na_palik",
        Vec3::new(0.060269356, 0.056140948, 0.061988432),
        Vec3::new(3.1792734, 2.1124904, 1.5790411),
    ),
    (
        "Nb",
        Vec3::new(3.420074, 2.7900932, 2.3956294),
        Vec3::new(3.4413946, 2.7376661, 2.5797458),
    ),
    (
        "Ni_palik",
        Vec3::new(2.3673046, 1.6633731, 1.4670781),
        Vec3::new(4.4988117, 3.050153, 2.3454392),
    ),
    (
        "Rh",
        Vec3::new(2.5857935, 1.8602164, 1.5542634),
        Vec3::new(6.7822604, 4.702987, 3.976073),
    ),
    (
        "Se",
        Vec3::new(4.0583115, 2.842935, 2.8208535),
        Vec3::new(0.75404954, 0.6384435, 0.52180755),
    ),
    (
        "Se-e",
        Vec3::new(5.722849, 4.165736, 4.0813384),
        Vec3::new(0.8711363, 1.1051575, 1.5653203),
    ),
    (
        "SiC",
        Vec3::new(3.1723416, 2.5259717, 2.4793706),
        Vec3::new(7.5376636e-7, 0.0, 1.0192531e-5),
    ),
    (
        "SnTe",
        Vec3::new(4.5242496, 1.981645, 1.2815913),
        Vec3::new(0.0, 0.0, 0.0),
    ),
    (
        "Ta",
        Vec3::new(2.062721, 2.3929389, 2.6279287),
        Vec3::new(2.4083598, 1.7414864, 1.9470278),
    ),
    (
        "Te",
        Vec3::new(7.3902335, 4.482105, 2.637106),
        Vec3::new(3.2560222, 3.5270588, 3.2920542),
    ),
    (
        "Te-e",
        Vec3::new(7.508907, 4.2964287, 2.3699877),
        Vec3::new(5.5839286, 4.947205, 3.9975922),
    ),
    (
        "ThF4",
        Vec3::new(1.8307136, 1.4422286, 1.3876476),
        Vec3::new(0.0, 0.0, 0.0),
    ),
    (
        "TiC",
        Vec3::new(3.7005284, 2.8374221, 2.582287),
        Vec3::new(3.265635, 2.3515892, 2.1727905),
    ),
    (
        "TiN",
        Vec3::new(1.6484497, 1.150516, 1.3798234),
        Vec3::new(3.368328, 1.9434981, 1.1020677),
    ),
    (
        "TiO2",
        Vec3::new(3.45661, 2.8017359, 2.905175),
        Vec3::new(0.00010526484, 0.0, 0.0006528865),
    ),
    (
        "TiO2-e",
        Vec3::new(3.1065645, 2.5131683, 2.5824444),
        Vec3::new(2.9751605e-5, 0.0, 0.00018269809),
    ),
    (
        "V_palik",
        Vec3::new(4.277582, 3.5129488, 2.7610714),
        Vec3::new(3.4913008, 2.8894548, 3.111522),
    ),
    (
        "VC",
        Vec3::new(3.657566, 2.752736, 2.532672),
        Vec3::new(3.0683007, 2.1986873, 1.9631927),
    ),
    (
        "VN",
        Vec3::new(2.8656023, 2.119189, 1.9400911),
        Vec3::new(3.0322425, 2.0561156, 1.6163063),
    ),
    (
        "W",
        Vec3::new(4.3708167, 3.3002465, 2.9984074),
        Vec3::new(3.5006406, 2.604874, 2.2732332),
    ),
];
