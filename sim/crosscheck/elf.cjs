// SPDX-License-Identifier: MIT
// Reads the flash contents of an AVR ELF file: what the boot loader would program.
'use strict';

const fs = require('fs');

const MACHINE_AVR = 83;
const SEGMENT_LOAD = 1;
// avr-gcc keeps RAM at this offset in its one address space; flash is below it.
const RAM_OFFSET = 0x800000;

// Flash words of the image, `flashBytes` long.
function readFlash(file, flashBytes) {
    const elf = fs.readFileSync(file);
    if (elf.readUInt32BE(0) !== 0x7f454c46 || elf.readUInt16LE(18) !== MACHINE_AVR) {
        throw new Error(`${file}: not an AVR ELF file`);
    }
    const flash = new Uint8Array(flashBytes);
    const headers = elf.readUInt32LE(28);
    const headerSize = elf.readUInt16LE(42);
    const headerCount = elf.readUInt16LE(44);
    for (let index = 0; index < headerCount; index++) {
        const header = headers + index * headerSize;
        const offset = elf.readUInt32LE(header + 4);
        const address = elf.readUInt32LE(header + 12); // physical: where it lies in flash
        const size = elf.readUInt32LE(header + 16);
        if (elf.readUInt32LE(header) === SEGMENT_LOAD && size > 0 && address < RAM_OFFSET) {
            if (address + size > flashBytes) {
                throw new Error(`${file}: ${address + size} bytes do not fit into the flash`);
            }
            flash.set(elf.subarray(offset, offset + size), address);
        }
    }
    return new Uint16Array(flash.buffer);
}

module.exports = { readFlash };
