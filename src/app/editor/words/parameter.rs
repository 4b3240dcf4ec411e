//! What one parameter is called, what is told of it, and phrases that many share.

/// All about one parameter.
#[derive(Debug, PartialEq)]
pub struct Words {
    /// The plugins it is about; empty for all that have no entry of their own.
    pub plugins: &'static [&'static str],
    /// In the file.
    pub name: &'static str,
    /// In the panel: short enough for its column.
    pub label: &'static str,
    /// What it does.
    pub about: &'static str,
    /// What values it takes, with their unit.
    pub range: &'static str,
    /// Behind the number in the panel.
    pub suffix: &'static str,
}

impl Words {
    /// The same words for these plugins alone.
    pub const fn of(mut self, plugins: &'static [&'static str]) -> Self {
        self.plugins = plugins;
        self
    }

    /// The same words with a unit behind the number.
    pub const fn in_units(mut self, suffix: &'static str) -> Self {
        self.suffix = suffix;
        self
    }
}

/// Of all plugins that have no entry of their own.
pub const fn words(name: &'static str, label: &'static str, about: &'static str, range: &'static str) -> Words {
    Words {
        plugins: &[],
        name,
        label,
        about,
        range,
        suffix: "",
    }
}

/// The range of reflectances.
pub const SHARE: &str = "0 to 1 per channel, or a texture";
/// The range of shares.
pub const UNIT: &str = "0 to 1, or a texture";
/// The range of factors on physical quantities.
pub const FACTOR: &str = "0 or more; 1 leaves it as it is";
/// The range of booleans.
pub const SWITCH: &str = "on or off";
/// The unit of angles.
pub const DEGREES: &str = "degrees";
/// The range of sampling weights.
pub const WHEEL: &str = "0 or more; 0 never, 1 as usual. The picture does not depend on it, only its noise";
