# libzoned_client.so: what a game in any language loads to join a server. It holds the client's half of the code, compiled once
# more: for any 64-bit PC, small, position-independent, and without a symbol but those of zoned_client.h.
set(LIBRARY client-sim/library)
set(LIBRARY_SOURCES)
foreach(FOLDER shared/core shared/math shared/clock shared/motion shared/wire client-sim/link client-sim/view ${LIBRARY})
  file(GLOB_RECURSE SOURCES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${FOLDER}/*.cpp)
  list(APPEND LIBRARY_SOURCES ${SOURCES})
endforeach()
add_library(zoned_client SHARED ${LIBRARY_SOURCES})
file(STRINGS ${LIBRARY}/zoned_client.h ABI REGEX "define ZONED_CLIENT_ABI_(MAJOR|MINOR) ")
string(REGEX MATCHALL "[0-9]+" ABI "${ABI}")
list(JOIN ABI "." ABI)
string(REGEX MATCH "^[0-9]+" ABI_MAJOR "${ABI}")
set(ZONED_CLIENT_VERSION ${ABI})
set_target_properties(zoned_client PROPERTIES
  VERSION ${ABI} SOVERSION ${ABI_MAJOR} UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 50
  CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
target_include_directories(zoned_client PRIVATE ${PROJECT_SOURCE_DIR} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_libraries(zoned_client PRIVATE Eigen3::Eigen OpenSSL::SSL OpenSSL::Crypto)
# A PC without AVX2 must be able to load it, and a game must not wait for a download. Nothing in it throws: where memory runs
# out, a jump leaves the call (client_memory.h). Strings are its own, as the system's take no memory of a client.
target_compile_options(zoned_client PRIVATE $<$<NOT:$<STREQUAL:${ZONED_TARGET},generic>>:-march=x86-64> -Wno-psabi $<IF:$<CXX_COMPILER_ID:Clang>,-Oz,-Os> -g0 -DNDEBUG -fno-math-errno -ffunction-sections -fdata-sections
  -fno-rtti -fno-exceptions -fno-unwind-tables -fno-asynchronous-unwind-tables -D_GLIBCXX_EXTERN_TEMPLATE=0
  $<IF:$<CXX_COMPILER_ID:Clang>,-flto,-flto=auto> $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
target_precompile_headers(zoned_client PRIVATE ${ZONED_PCH})
# nodelete: the lookup of a name may outlive an unloaded library.
# lld does not know GCC's link-time optimization, nor bfd Clang's.
target_link_options(zoned_client PRIVATE -fuse-ld=$<IF:$<CXX_COMPILER_ID:Clang>,lld,bfd> -Wl,--version-script=${PROJECT_SOURCE_DIR}/${LIBRARY}/zoned_client.map
  -Wl,--gc-sections -Wl,-z,nodelete -Wl,-z,now $<IF:$<CXX_COMPILER_ID:Clang>,-flto,-flto=auto> $<$<CXX_COMPILER_ID:Clang>:-Wl,--icf=safe> -Os -g0)
# Its segments need no pages of their own: a hundredth of its size.
target_link_options(zoned_client PRIVATE -Wl,-z,noseparate-code)
# Games load no sanitizer's runtime first: the library is plain in every build, and unit_client and fuzz_client run its code
# under sanitizers.
target_compile_options(zoned_client PRIVATE -fno-sanitize=all)
target_link_options(zoned_client PRIVATE -fno-sanitize=all)
set_target_properties(zoned_client PROPERTIES LINK_DEPENDS ${PROJECT_SOURCE_DIR}/${LIBRARY}/zoned_client.map)
