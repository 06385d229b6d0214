# Windows on x86-64: Debian's MinGW-w64, libraries that tools/windows_root builds into build-windows/root, and Wine to run what is
# built.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)  # of the two the one with std::thread
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)

# GCC aligns the stack to 16 bytes there, whatever a vector that it saves on it needs (its bug 54412). Debian's GCC 12 therefore
# writes moves that need no alignment; for others the assembler does. No other AVX instruction minds. Tests: VectorsOnStack.
set(FLAGS "-Wa,-muse-unaligned-vector-move")
# Windows 10; and what windows.h would define without being asked for.
string(APPEND FLAGS " -D_WIN32_WINNT=0x0A00 -DNOMINMAX -DWIN32_LEAN_AND_MEAN")
set(CMAKE_C_FLAGS_INIT "${FLAGS}")
set(CMAKE_CXX_FLAGS_INIT "${FLAGS}")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static")
set(ZLIB_USE_STATIC_LIBS ON)

if(DEFINED ENV{FOLDPROOF_WINDOWS_ROOT})  # tools/windows_root itself builds by this file
  set(WINDOWS_ROOT $ENV{FOLDPROOF_WINDOWS_ROOT})
else()
  get_filename_component(WINDOWS_ROOT ${CMAKE_CURRENT_LIST_DIR}/../build-windows/root ABSOLUTE)
  execute_process(COMMAND ${CMAKE_CURRENT_LIST_DIR}/../tools/windows_root ${WINDOWS_ROOT} COMMAND_ERROR_IS_FATAL ANY)
endif()
set(CMAKE_FIND_ROOT_PATH ${WINDOWS_ROOT} ${WINDOWS_ROOT}/usr ${WINDOWS_ROOT}/usr/x86_64-w64-mingw32 /usr/x86_64-w64-mingw32)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_LIBDIR} ${WINDOWS_ROOT}/lib/pkgconfig)
# With a home of its own, names in UTF-8 on this side, too, and one processor: Wine takes long to start the threads of small loops.
# Without Wine's debugger, after which a program that crashed may end with exit code 0.
set(CMAKE_CROSSCOMPILING_EMULATOR taskset -c 0 env WINEDEBUG=-all WINEDLLOVERRIDES=winedbg.exe=d LC_ALL=C.UTF-8
  WINEPREFIX=${CMAKE_CURRENT_LIST_DIR}/../build-windows/wine /usr/lib/wine/wine64)
