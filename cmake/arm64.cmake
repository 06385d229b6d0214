# 64-bit ARM: ./dev arm64.
set(CROSS_NAME arm64)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
include(${CMAKE_CURRENT_LIST_DIR}/cross.cmake)
