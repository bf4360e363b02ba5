adit_fuzz(detect ROUNDS 150 DEPENDS adit_detect)
