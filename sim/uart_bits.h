// SPDX-License-Identifier: MIT
//
// Bits of the registers of UART 0.
#pragma once

// Bits of UCSR0A.
#define RXC  0x80U
#define TXC  0x40U
#define UDRE 0x20U
#define FE   0x10U
#define DOR  0x08U
#define UPE  0x04U
#define U2X  0x02U
#define MPCM 0x01U
// Bits of UCSR0B.
#define RXCIE 0x80U
#define TXCIE 0x40U
#define UDRIE 0x20U
#define RXEN  0x10U
#define TXEN  0x08U
#define UCSZ2 0x04U
// Bits of UCSR0C.
#define UMSEL  0xC0U
#define UPM    0x30U
#define USBS   0x08U
#define UCSZ   0x06U
#define FORMAT (UPM | UCSZ) // what sender and receiver must agree on
