// The headers that CMake precompiles for all test programs (tests/CMakeLists.txt) hang on this source.
