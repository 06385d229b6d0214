/// What systems name differently about sockets. The bodies are in posix/ and windows/.
#pragma once

#include <cstdint>
#include <system_error>

namespace foldproof::system {

/// Lets a server take a port as soon as another has ended, but never one that another has.
void take_ended_port(std::intptr_t socket);

/// Lets as many connections wait as the system allows. False: it cannot listen; socket_error() says why.
bool listen(std::intptr_t socket);

void close_socket(std::intptr_t socket);

/// Of the last call of a socket function that failed.
std::error_code socket_error();

}  // namespace foldproof::system
