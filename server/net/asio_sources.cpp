// The parts of Asio that are no templates, compiled once: elsewhere they took a sixth of the time
// that sources with sockets take to build.
#include "server/net/udp_endpoint.h"

#include <asio/impl/src.hpp>
#include <asio/ssl/impl/src.hpp>
