// SPDX-License-Identifier: MIT
//
// Bits of the registers of UART 0.
#pragma once

// Bits of UCSR0A.
#define RXC  0x80U // a received character waits in UDR0
#define TXC  0x40U // the last frame is out and UDR0 is empty
#define UDRE 0x20U // UDR0 takes another character to send
#define FE   0x10U // the waiting character had no stop bit
#define DOR  0x08U // a character was lost before the waiting one
#define UPE  0x04U // the waiting character had the wrong parity
#define U2X  0x02U // 8 samples a bit instead of 16
#define MPCM 0x01U // multi-processor mode
// Bits of UCSR0B.
#define RXCIE 0x80U // interrupt while RXC0
#define TXCIE 0x40U // interrupt on TXC0
#define UDRIE 0x20U // interrupt while UDRE0
#define RXEN  0x10U // receiver on
#define TXEN  0x08U // transmitter on
#define UCSZ2 0x04U // 9 data bits
// Bits of UCSR0C.
#define UMSEL  0xC0U        // synchronous modes
#define UPM    0x30U        // parity: 0 none, 2 even, 3 odd
#define USBS   0x08U        // two stop bits
#define UCSZ   0x06U        // 5 data bits plus this field
#define FORMAT (UPM | UCSZ) // what sender and receiver must agree on
