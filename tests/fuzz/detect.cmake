adit_fuzz(detect ROUNDS 5000 DEPENDS adit_detect)
