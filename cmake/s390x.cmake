# IBM Z, which is big-endian: ./dev s390x.
set(CROSS_NAME s390x)
set(CMAKE_SYSTEM_PROCESSOR s390x)
include(${CMAKE_CURRENT_LIST_DIR}/cross.cmake)
