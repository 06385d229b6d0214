# include/foldproof/ipc_toolkit.h against a stand-in for the interfaces of each release of ipc-toolkit, as 13 for 1.3.
foreach(RELEASE 13 14 15 16)
  set(PROGRAM test_ipc_toolkit_${RELEASE})
  add_executable(${PROGRAM} ipc_toolkit/ipc_toolkit_test.cpp ipc_toolkit/stand_in/stand_in.cpp)
  target_compile_definitions(${PROGRAM} PRIVATE IPC_STAND_IN=${RELEASE})
  target_include_directories(${PROGRAM} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR} ipc_toolkit/stand_in)
  target_link_libraries(${PROGRAM} PRIVATE foldproof foldproof_oracle GTest::gmock GTest::gtest_main)
  foldproof_discover(${PROGRAM} ipc_toolkit quick * TEST_PREFIX ${RELEASE}.)
  list(APPEND IPC_TOOLKIT_PROGRAMS ${PROGRAM})
endforeach()
# What a simulator cannot be built with is told by the first error: C++17, as ipc-toolkit asks for, and foldproof_model's
# alignment beside ipc-toolkit's.
set(OPTIONS_OF_cxx17 -std=c++17)
set(ERROR_OF_cxx17 "Foldproof needs C[+][+]20")
set(OPTIONS_OF_alignment -std=c++20 -DEIGEN_DONT_VECTORIZE -DEIGEN_MAX_ALIGN_BYTES=64)
set(ERROR_OF_alignment "foldproof_model has Eigen align more")
foreach(CASE cxx17 alignment)
  add_test(NAME ipc_toolkit_${CASE} COMMAND ${CMAKE_CXX_COMPILER} ${OPTIONS_OF_${CASE}} -fsyntax-only -Wfatal-errors
    -I${PROJECT_SOURCE_DIR}/include -I${CMAKE_CURRENT_SOURCE_DIR}/ipc_toolkit/stand_in
    -isystem $<TARGET_PROPERTY:Eigen3::Eigen,INTERFACE_INCLUDE_DIRECTORIES> ${PROJECT_SOURCE_DIR}/examples/ipc_toolkit.cpp)
  set_tests_properties(ipc_toolkit_${CASE} PROPERTIES PASS_REGULAR_EXPRESSION "error: .*${ERROR_OF_${CASE}}")
endforeach()
foldproof_label(ipc_toolkit quick ${IPC_TOOLKIT_PROGRAMS})
