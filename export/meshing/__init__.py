"""The boundary of voxels as a closed mesh, straight from the words of a tree."""
