# Run at every build: writes OUTPUT, a header with a hash of the sources that decide what a solve
# computes, and touches it only when the hash has changed.
#   cmake -DSOURCE_DIR=... -DOUTPUT=... -DVERSION=... -DBUILD_TYPE=... -P BuildId.cmake
file(GLOB_RECURSE sources LIST_DIRECTORIES false RELATIVE ${SOURCE_DIR}
  ${SOURCE_DIR}/common/*.h ${SOURCE_DIR}/common/*.cc ${SOURCE_DIR}/worker/*.h
  ${SOURCE_DIR}/worker/*.cc ${SOURCE_DIR}/server/*.h ${SOURCE_DIR}/server/*.cc
  ${SOURCE_DIR}/proto/*.proto ${SOURCE_DIR}/CMakeLists.txt)
list(SORT sources)
set(all "")
foreach(source ${sources})
  file(SHA256 ${SOURCE_DIR}/${source} hash)
  string(APPEND all "${source} ${hash}\n")
endforeach()
string(SHA256 hash "${all}")
string(SUBSTRING ${hash} 0 16 hash)
set(text "#pragma once\n#define ISOLUX_VERSION \"${VERSION}\"\n#define ISOLUX_BUILD_TYPE \"${BUILD_TYPE}\"\n#define ISOLUX_SOURCE_HASH \"${hash}\"\n")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT old STREQUAL text)
  file(WRITE ${OUTPUT} "${text}")
endif()
