#include "system/socket.h"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

namespace foldproof::system {

void take_ended_port(std::intptr_t socket) {
  const int yes = 1;
  ::setsockopt(static_cast<int>(socket), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
}

bool listen(std::intptr_t socket) { return ::listen(static_cast<int>(socket), SOMAXCONN) == 0; }

void close_socket(std::intptr_t socket) { ::close(static_cast<int>(socket)); }

std::error_code socket_error() { return {errno, std::generic_category()}; }

}  // namespace foldproof::system
