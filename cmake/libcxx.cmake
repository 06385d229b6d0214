# For the preset libcxx: GoogleTest, too, is compiled with libc++.
include(FetchContent)
FetchContent_Declare(GTest SOURCE_DIR /usr/src/googletest OVERRIDE_FIND_PACKAGE)
set(INSTALL_GTEST OFF)
