//! What is not read of animations: one sentence for each kind, because a file may have thousands of channels.

/// The kinds of what is passed over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A channel of morph weights.
    Weights,
    /// A channel of something else that is not read.
    Property,
    /// A channel of a node that has a matrix.
    Matrix,
    /// An animation that drives what an earlier one drives.
    Rival,
    /// An animation that cannot be read.
    Broken,
}

impl Kind {
    fn things(self) -> &'static str {
        match self {
            Self::Weights | Self::Property | Self::Matrix => "channel",
            Self::Rival | Self::Broken => "animation",
        }
    }
}

/// The first of each kind, in words, and the number of those that follow it.
#[derive(Clone, Default)]
pub(super) struct PassedOver(Vec<(Kind, String, usize)>);

impl PassedOver {
    /// Notes one; `sentence` says what it is, without a full stop.
    pub fn note(&mut self, kind: Kind, sentence: impl FnOnce() -> String) {
        self.add(kind, sentence, 0);
    }

    /// Notes all of `others`.
    pub fn append(&mut self, others: Self) {
        for (kind, sentence, more) in others.0 {
            self.add(kind, || sentence, more);
        }
    }

    fn add(&mut self, kind: Kind, sentence: impl FnOnce() -> String, more: usize) {
        match self.0.iter_mut().find(|(known, ..)| *known == kind) {
            Some((_, _, others)) => *others += 1 + more,
            None => self.0.push((kind, sentence(), more)),
        }
    }

    /// A sentence for each kind.
    pub fn sentences(self) -> impl Iterator<Item = String> {
        self.0.into_iter().map(|(kind, sentence, more)| match more {
            0 => sentence,
            1 => format!("{sentence}; so it is with another {}", kind.things()),
            _ => format!("{sentence}; so it is with {more} other {}s", kind.things()),
        })
    }
}
