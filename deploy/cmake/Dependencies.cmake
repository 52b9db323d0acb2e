# Every outside package, found once and given one name (isolux::dep_*), so that the rest of the
# build never meets a packaging quirk of Debian 12.
find_package(Threads REQUIRED)
find_package(Protobuf REQUIRED)          # module mode only on Debian 12, and before gRPC
find_package(gRPC CONFIG REQUIRED)
find_package(glm CONFIG REQUIRED)
find_package(embree 3 CONFIG REQUIRED)
find_package(spdlog CONFIG REQUIRED)
find_package(CLI11 CONFIG REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)
find_package(tl-expected CONFIG REQUIRED)
find_package(tinyobjloader CONFIG REQUIRED)
find_package(TinyGLTF CONFIG REQUIRED)  # Debian's shared library
find_package(SQLite3 REQUIRED)
find_package(PNG REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(xxhash REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(stb REQUIRED IMPORTED_TARGET stb)
pkg_check_modules(openexr REQUIRED IMPORTED_TARGET OpenEXR)

add_library(isolux_dep_grpc INTERFACE)
target_link_libraries(isolux_dep_grpc INTERFACE gRPC::grpc++ gRPC::grpc++_reflection protobuf::libprotobuf)
foreach(pair
    grpc=isolux_dep_grpc glm=glm::glm embree=embree spdlog=spdlog::spdlog cli11=CLI11::CLI11
    json=nlohmann_json::nlohmann_json expected=tl::expected obj=tinyobjloader::tinyobjloader_double
    gltf=TinyGLTF::TinyGLTF     sqlite=SQLite::SQLite3 png=PNG::PNG xxhash=PkgConfig::xxhash stb=PkgConfig::stb
    openexr=PkgConfig::openexr protobuf=protobuf::libprotobuf threads=Threads::Threads)
  string(REPLACE "=" ";" pair "${pair}")
  list(GET pair 0 name)
  list(GET pair 1 target)
  add_library(isolux_alias_${name} INTERFACE)
  target_link_libraries(isolux_alias_${name} INTERFACE ${target})
  add_library(isolux::dep_${name} ALIAS isolux_alias_${name})
endforeach()

# The pages are bundled by programs, not libraries.
find_program(NODE_PROGRAM NAMES node nodejs)
find_program(NPM_PROGRAM npm)
if(NOT NODE_PROGRAM OR NOT NPM_PROGRAM)
  message(FATAL_ERROR "node (18 or newer) and npm bundle the pages of `isolux report` and are not "
    "here: install Debian's packages nodejs and npm, or run deploy/install-deps.sh")
endif()
execute_process(COMMAND ${NODE_PROGRAM} --version OUTPUT_VARIABLE node_version OUTPUT_STRIP_TRAILING_WHITESPACE)
string(REGEX REPLACE "^v" "" node_version "${node_version}")
if(node_version VERSION_LESS 18)
  message(FATAL_ERROR "${NODE_PROGRAM} is version '${node_version}'; the pages need node 18 or newer")
endif()
