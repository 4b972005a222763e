# The Debian packages: cmake --build build --target package makes build/zoned_VERSION_ARCH.deb, for those who run worlds, and
# build/zoned-dev_VERSION_ARCH.deb, for those who make games.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME zoned)
set(CPACK_PACKAGE_VENDOR "the zoned authors")
set(CPACK_PACKAGE_CONTACT "the zoned authors <maintainers@zoned.internal>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "dedicated authoritative multiplayer game server")
set(CPACK_PACKAGE_DESCRIPTION "zoned simulates the physics and the AI of a world at a fixed tick. It tells
each player what moves around them, with a bound on every error. The package
holds the server, a client that plays as any number of bots, and worlds.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_CHECKSUM SHA256)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL Unspecified development)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_NAME zoned)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_SECTION net)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_DEPENDS "adduser")
# What is linked with libzoned_client depends on this package.
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(CPACK_COMPONENT_UNSPECIFIED_DESCRIPTION "${CPACK_PACKAGE_DESCRIPTION}")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME zoned-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "zoned simulates the physics and the AI of a world at a fixed tick. It tells
each player what moves around them, with a bound on every error. This package
holds headers and libraries for game rules in C++ and for clients.")
# What its headers and libraries lead to.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "zoned (= ${PROJECT_VERSION}), g++, cmake, ninja-build, libasio-dev, libcli11-dev, \
libeigen3-dev, libgtest-dev, liblua5.4-dev, libnats-dev, libpng-dev, libpqxx-dev, libprotobuf-dev, librecast-dev, libspdlog-dev, \
libsqlite3-dev, libssl-dev, opencl-headers")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(DEBIAN ${PROJECT_SOURCE_DIR}/docker/debian)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_CONTROL_EXTRA ${DEBIAN}/postinst ${DEBIAN}/prerm ${DEBIAN}/postrm ${DEBIAN}/conffiles ${DEBIAN}/triggers)
# What lies outside of /usr is no part of cmake --install: it is added to the package alone.
set(CPACK_PRE_BUILD_SCRIPTS ${DEBIAN}/stage.cmake)
set(CPACK_ZONED_SOURCE_DIR ${PROJECT_SOURCE_DIR})
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
include(CPack)
