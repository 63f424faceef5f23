"""The filters that come with meshlab_symrecon, one file each."""
