# 64-bit ARM on another machine: Debian's cross compiler, libraries that tools/cross_root unpacks into build-arm64/root, and QEMU
# to run what is built.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)

get_filename_component(CROSS_ROOT ${CMAKE_CURRENT_LIST_DIR}/../build-arm64/root ABSOLUTE)
execute_process(COMMAND ${CMAKE_CURRENT_LIST_DIR}/../tools/cross_root arm64 ${CROSS_ROOT} COMMAND_ERROR_IS_FATAL ANY)
set(CMAKE_FIND_ROOT_PATH ${CROSS_ROOT} /usr/aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_LIBDIR} ${CROSS_ROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${CROSS_ROOT}/usr/share/pkgconfig)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${CROSS_ROOT})
# Libraries that are named without a path, and libraries of libraries.
set(CROSS_LIBRARIES ${CROSS_ROOT}/usr/lib/aarch64-linux-gnu:${CROSS_ROOT}/lib/aarch64-linux-gnu)
string(REPLACE ":" " -L" SEARCHED ${CROSS_LIBRARIES})
set(CMAKE_EXE_LINKER_FLAGS_INIT "-L${SEARCHED} -Wl,--allow-shlib-undefined -Wl,-rpath-link,${CROSS_LIBRARIES}")
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L /usr/aarch64-linux-gnu -E LD_LIBRARY_PATH=${CROSS_LIBRARIES})
