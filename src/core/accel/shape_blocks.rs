//! The list of a hierarchy's blocks, and edits of single shapes in it.

use super::shape_block::{Members, ShapeBlock};
use super::shared_list::SharedList;

/// The blocks of a hierarchy. Copies that differ in few blocks share the memory of the others, whatever the numbers of
/// their shapes.
#[derive(Clone, Debug)]
pub(super) struct ShapeBlocks {
    blocks: SharedList<ShapeBlock>,
    members: Vec<Members>,
}

impl ShapeBlocks {
    pub fn len(&self) -> usize {
        self.members.len()
    }

    #[inline(always)]
    pub fn get(&self, place: usize) -> (&ShapeBlock, &Members) {
        (&self.blocks[place], &self.members[place])
    }

    pub fn members(&self) -> &[Members] {
        &self.members
    }

    /// The blocks that the list was made of, and their members; they are all blocks until the list is edited.
    pub fn made(&self) -> (&[ShapeBlock], &[Members]) {
        let blocks = self.blocks.made();
        (blocks, &self.members[..blocks.len().min(self.len())])
    }

    pub fn replace(&mut self, place: usize, (block, members): (ShapeBlock, Members)) {
        self.blocks.replace(place, block);
        self.members[place] = members;
    }

    pub fn truncate(&mut self, len: usize) {
        self.blocks.truncate(len);
        self.members.truncate(len);
    }

    pub fn extend(&mut self, blocks: Vec<(ShapeBlock, Members)>) {
        let (blocks, members): (Vec<_>, Vec<_>) = blocks.into_iter().unzip();
        self.blocks.extend(blocks);
        self.members.extend(members);
    }

    /// Gives the shapes new numbers.
    pub fn renumber(&mut self, new: impl Fn(u32) -> u32) {
        self.members.iter_mut().for_each(|members| members.renumber(&new));
    }

    pub fn bytes(&self) -> usize {
        self.len() * (size_of::<ShapeBlock>() + size_of::<Members>())
    }
}

impl From<Vec<(ShapeBlock, Members)>> for ShapeBlocks {
    fn from(blocks: Vec<(ShapeBlock, Members)>) -> Self {
        let (blocks, members): (Vec<_>, Vec<_>) = blocks.into_iter().unzip();
        Self {
            blocks: blocks.into(),
            members,
        }
    }
}
