//! The captions of rows.

use crate::scene::ParameterInfo;

/// The caption of a row, with the explanation that is shown when the pointer rests there.
#[derive(Clone, Copy, Debug)]
pub struct Caption<'a> {
    /// The name that the row shows and by which its control is found.
    pub text: &'a str,
    /// The name of the value among the differences of selected things; without one, the row is never marked.
    pub(super) name: &'a str,
    pub(super) info: Option<&'static ParameterInfo>,
    /// The tool tip of a row that is no parameter of the format.
    pub(super) about: Option<&'a str>,
}

impl<'a> From<&'a str> for Caption<'a> {
    fn from(text: &'a str) -> Self {
        Self {
            text,
            name: "",
            info: None,
            about: None,
        }
    }
}

impl<'a> From<(&'a str, &'a str)> for Caption<'a> {
    fn from((text, name): (&'a str, &'a str)) -> Self {
        Self {
            name,
            ..Self::from(text)
        }
    }
}

impl<'a> From<&'a String> for Caption<'a> {
    fn from(text: &'a String) -> Self {
        Self::from(text.as_str())
    }
}

impl<'a> Caption<'a> {
    /// Returns the same explanation under another name.
    pub(crate) fn titled(self, text: &'a str) -> Self {
        Self { text, ..self }
    }

    /// The caption with this tool tip in place of the explanation of a parameter.
    pub(crate) fn explained(self, about: &'a str) -> Self {
        Self {
            info: None,
            about: Some(about),
            ..self
        }
    }

    /// The caption of a part of the value, which has no explanation of its own.
    pub(crate) fn part(self, text: &'a str) -> Self {
        Self {
            text,
            info: None,
            ..self
        }
    }
}

impl From<&'static ParameterInfo> for Caption<'_> {
    fn from(info: &'static ParameterInfo) -> Self {
        Self {
            text: info.label,
            name: info.name,
            info: Some(info),
            about: None,
        }
    }
}
