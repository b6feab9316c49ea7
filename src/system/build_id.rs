//! The build ID that the linker writes into ELF files.

/// The build ID of this library, or of the program that it is linked into; `None` if the linker
/// wrote none.
pub fn build_id() -> Option<Vec<u8>> {
    /// Type and owner of the note.
    const NT_GNU_BUILD_ID: u32 = 3;
    const OWNER: &[u8] = b"GNU\0";

    struct Search {
        inside: usize,
        found: Option<Vec<u8>>,
    }

    /// Looks at one loaded object. Any result but 0 ends the search.
    ///
    /// # Safety
    /// Must be called by `dl_iterate_phdr` with a pointer to a [`Search`].
    unsafe extern "C" fn look(info: *mut libc::dl_phdr_info, _size: usize, search: *mut libc::c_void) -> libc::c_int {
        // SAFETY: `dl_iterate_phdr` passes a valid `info`, and the [`Search`] is borrowed by nobody
        // else during the call.
        let (info, search) = unsafe { (&*info, &mut *search.cast::<Search>()) };
        if info.dlpi_phdr.is_null() {
            return 0;
        }
        // SAFETY: `dlpi_phdr` points to `dlpi_phnum` program headers, which stay mapped.
        let headers = unsafe { std::slice::from_raw_parts(info.dlpi_phdr, usize::from(info.dlpi_phnum)) };
        let start = |header: &libc::Elf64_Phdr| (info.dlpi_addr as usize).wrapping_add(header.p_vaddr as usize);
        let holds = |header: &libc::Elf64_Phdr| {
            header.p_type == libc::PT_LOAD && search.inside.wrapping_sub(start(header)) < header.p_memsz as usize
        };
        if !headers.iter().any(holds) {
            return 0;
        }
        for header in headers.iter().filter(|header| header.p_type == libc::PT_NOTE) {
            // SAFETY: notes are part of a loaded segment and `p_memsz` bytes long.
            let notes = unsafe { std::slice::from_raw_parts(start(header) as *const u8, header.p_memsz as usize) };
            search.found = search.found.take().or_else(|| note(notes, NT_GNU_BUILD_ID, OWNER));
        }
        1
    }

    let mut search = Search { inside: look as *const () as usize, found: None };
    // SAFETY: `look` has the signature that `dl_iterate_phdr` expects, and `search` outlives the
    // call.
    unsafe { libc::dl_iterate_phdr(Some(look), (&raw mut search).cast()) };
    search.found
}

/// Content of the first note with this type and owner. A note consists of three numbers, the
/// owner's name and the content, both padded to a multiple of four bytes.
fn note(mut notes: &[u8], kind: u32, owner: &[u8]) -> Option<Vec<u8>> {
    loop {
        let (header, rest) = notes.split_at_checked(12)?;
        let (numbers, _) = header.as_chunks::<4>();
        let [name, content, found] = [0, 1, 2].map(|place: usize| u32::from_ne_bytes(numbers[place]) as usize);
        let (whose, rest) = rest.split_at_checked(name.next_multiple_of(4))?;
        let what = rest.get(..content)?;
        if found == kind as usize && whose.get(..name) == Some(owner) {
            return Some(what.to_vec());
        }
        notes = rest.get(content.next_multiple_of(4)..)?;
    }
}

#[cfg(test)]
mod tests {
    use super::note;

    #[test]
    fn notes_are_found_and_damaged_ones_are_not() {
        let made = |name: &[u8], content: &[u8], kind: u32| {
            let mut bytes: Vec<u8> =
                [name.len() as u32, content.len() as u32, kind].iter().flat_map(|n| n.to_ne_bytes()).collect();
            for part in [name, content] {
                bytes.extend_from_slice(part);
                bytes.resize(bytes.len().next_multiple_of(4), 0);
            }
            bytes
        };
        let notes = [made(b"GNU\0", &[1], 5), made(b"X\0", &[2, 3], 3), made(b"GNU\0", &[4, 5, 6, 7, 8], 3)].concat();
        assert_eq!(note(&notes, 3, b"GNU\0"), Some(vec![4, 5, 6, 7, 8]));
        assert_eq!(note(&notes, 4, b"GNU\0"), None);
        for length in 0..notes.len() - 3 {
            assert_eq!(note(&notes[..length], 3, b"GNU\0"), None, "{length}");
        }
        let mut endless = notes;
        endless[..4].copy_from_slice(&u32::MAX.to_ne_bytes());
        assert_eq!(note(&endless, 3, b"GNU\0"), None);
    }
}
