#include "system/socket.h"

#include <winsock2.h>

#include "text.h"

namespace foldproof::system {

void take_ended_port(std::intptr_t socket) {
  // A port is free as soon as its server has ended; without this, another server could take it before.
  const int yes = 1;
  ::setsockopt(static_cast<SOCKET>(socket), SOL_SOCKET, SO_EXCLUSIVEADDRUSE,
               reinterpret_cast<const char*>(&yes), sizeof yes);
}

bool listen(std::intptr_t socket) { return ::listen(static_cast<SOCKET>(socket), SOMAXCONN) == 0; }

void close_socket(std::intptr_t socket) { ::closesocket(static_cast<SOCKET>(socket)); }

std::error_code socket_error() {
  const int code = ::WSAGetLastError();
  if (code == WSAEADDRINUSE) return std::make_error_code(std::errc::address_in_use);
  if (code == WSAEACCES) return std::make_error_code(std::errc::permission_denied);
  return windows_error(static_cast<unsigned long>(code));
}

}  // namespace foldproof::system
