# The libraries of Debian 12 that adit stands on; toolchain/packages.txt names their packages.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(yaml-cpp 0.7 REQUIRED)
find_package(Ceres 2.1 REQUIRED)
find_package(spdlog REQUIRED)
find_package(CLI11 REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(ARAVIS REQUIRED IMPORTED_TARGET aravis-0.8)
pkg_check_modules(MODBUS REQUIRED IMPORTED_TARGET libmodbus)
pkg_check_modules(CPPUTEST REQUIRED IMPORTED_TARGET cpputest)

# OpenCV's CMake files come only with the package of all its modules (hundreds of MB); four modules do.
add_library(adit_opencv INTERFACE)
find_path(OPENCV_INCLUDE opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
target_include_directories(adit_opencv SYSTEM INTERFACE ${OPENCV_INCLUDE})
foreach(module calib3d imgcodecs imgproc core)
  find_library(OPENCV_${module} opencv_${module} REQUIRED)
  target_link_libraries(adit_opencv INTERFACE ${OPENCV_${module}})
endforeach()

# Markers of ChArUco boards, for the workstation alone. Debian has them only among all contributed modules
# (330 MB installed).
find_library(OPENCV_ARUCO opencv_aruco REQUIRED)
add_library(adit_opencv_aruco INTERFACE)
target_link_libraries(adit_opencv_aruco INTERFACE ${OPENCV_ARUCO} adit_opencv)
